#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <string>
#include <variant>
#include <vector>

#include "daemon/arguments.h"
#include "daemon/configuration.h"
#include "daemon/daemon.h"
#include "daemon/protocols.h"
#include "daemon/service/service_log.h"

namespace {

using namespace cansyncd;

int print(const std::string& text) {
  return std::fputs(text.c_str(), stdout) >= 0 && std::fflush(stdout) == 0 ? exit_code::done
                                                                           : exit_code::cannot_start;
}

int run(const Arguments& arguments) {
  const std::vector<std::string> settings = overrides(arguments);
  if (arguments.print_default_config) return print(print_default_config(settings, protocols()));
  if (arguments.print_options_markdown) return print(print_options_markdown(protocols()));
  if (arguments.print_options_man) return print(print_options_man(protocols()));
  const bool check_only = !arguments.check.empty();
  const bool dbc_only = !arguments.dbc.empty();
  const std::string& path = check_only ? arguments.check : dbc_only ? arguments.dbc : arguments.config;
  const LoadedConfig config = load_configuration(path, settings, protocols());
  if (!config.problems.empty()) {
    if (check_only || dbc_only) {
      fmt::print(stderr, "{}", problems_text(config.problems));
    } else {
      tell_wrong_configuration(config.bus_name, config.problems);
    }
    return exit_code::wrong_config;
  }
  if (dbc_only && !config.dbc_text) {
    fmt::print(stderr, "cansyncd: {}: the protocol of this bus has no DBC file\n", path);
    return exit_code::wrong_usage;
  }
  if (dbc_only) return print(config.dbc_text());
  if (check_only) return print(fmt::format("{}: in order\n{}", path, config.check_text));
  return run_daemon(config, path, settings);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const auto parsed = parse_arguments(argc, argv);
    if (const auto* arguments = std::get_if<Arguments>(&parsed)) return run(*arguments);
    const auto& end = std::get<CommandLineEnd>(parsed);
    if (!end.wrong) return print(end.text);
    std::fputs(end.text.c_str(), stderr);
    return exit_code::wrong_usage;
  } catch (const std::exception& error) {
    std::fputs("cansyncd: ", stderr);
    std::fputs(error.what(), stderr);
    std::fputs("\n", stderr);
    return exit_code::cannot_start;
  }
}
