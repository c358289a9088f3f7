#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <string>
#include <variant>

#include "daemon/arguments.h"
#include "daemon/cansync/config/bus_budget.h"
#include "daemon/cansync/config/bus_budget_text.h"
#include "daemon/cansync/config/dbc.h"
#include "daemon/cansync/config/print.h"
#include "daemon/daemon.h"
#include "daemon/service/service_log.h"

namespace {

using namespace cansyncd;

int print(const std::string& text) {
  return std::fputs(text.c_str(), stdout) >= 0 && std::fflush(stdout) == 0 ? exit_code::done
                                                                           : exit_code::cannot_start;
}

int run(const Arguments& arguments) {
  if (arguments.print_default_config) return print(default_config());
  if (arguments.print_options_markdown) return print(options_markdown());
  if (arguments.print_options_man) return print(options_man());
  const bool check_only = !arguments.check.empty();
  const bool dbc_only = !arguments.dbc.empty();
  const std::string& path = check_only ? arguments.check : dbc_only ? arguments.dbc : arguments.config;
  ConfigFile file = load_checked(path, overrides(arguments));
  if (!file.problems.empty()) {
    if (check_only || dbc_only) {
      fmt::print(stderr, "{}", problems_text(file.problems));
    } else {
      tell_wrong_configuration(file.config.bus.name, file.problems);
    }
    return exit_code::wrong_config;
  }
  if (dbc_only) return print(dbc_text(file.config));
  if (check_only) {
    return print(fmt::format("{}: in order\n{}", path, budget_text(bus_budget(budget_input(file.config)))));
  }
  return run_daemon(std::move(file), overrides(arguments));
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
