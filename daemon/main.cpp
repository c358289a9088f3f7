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

int print_dbc(const std::string& path, const std::vector<std::string>& settings) {
  const LoadedConfig config = load_configuration(path, settings, protocols());
  if (!config.problems.empty()) {
    fmt::print(stderr, "{}", problems_text(config.problems));
    return exit_code::wrong_config;
  }
  if (config.dbc_text) return print(config.dbc_text());
  fmt::print(stderr, "cansyncd: {}: the protocol of this bus has no DBC file\n", path);
  return exit_code::wrong_usage;
}

int run(const Arguments& arguments) {
  const std::vector<std::string> settings = overrides(arguments);
  if (arguments.print_default_config) return print(print_default_config(settings, protocols()));
  if (arguments.print_options_markdown) return print(print_options_markdown(protocols()));
  if (arguments.print_options_man) return print(print_options_man(protocols()));
  if (!arguments.dbc.empty()) return print_dbc(arguments.dbc, settings);
  const bool check_only = !arguments.check.empty();
  std::vector<LoadedConfig> files;
  for (const std::string& path : check_only ? arguments.check : arguments.config)
    files.push_back(load_configuration(path, settings, protocols()));
  int end = exit_code::done;
  const auto tell = [&](const std::string& bus, const std::vector<config::Problem>& problems) {
    if (problems.empty()) return;
    end = exit_code::wrong_config;
    if (check_only) {
      fmt::print(stderr, "{}", problems_text(problems));
    } else {
      tell_wrong_configuration(bus, problems);
    }
  };
  for (const LoadedConfig& file : files) tell(file.daemon.bus.name, file.problems);
  if (end == exit_code::done) tell(files.front().daemon.bus.name, check_together(files));
  if (end != exit_code::done) return end;
  if (!check_only) return run_daemon(files, settings);
  for (const LoadedConfig& file : files) {
    end = print(fmt::format("{}: in order\n{}", file.path, file.check_text));
    if (end != exit_code::done) return end;
  }
  return end;
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
