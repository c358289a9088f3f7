#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "daemon/bus_budget.h"
#include "daemon/bus_budget_text.h"
#include "daemon/config_print.h"
#include "daemon/daemon.h"

namespace {

using namespace cansyncd;

/// What stands on the command line.
struct Arguments {
  std::string config;
  std::string check;
  std::string trace;
  std::string domain;
  std::vector<std::string> set;
  bool print_default_config = false;
  bool print_options_markdown = false;
};

void describe(CLI::App& app, Arguments& arguments) {
  app.set_version_flag("--version", std::string("cansyncd " CANSYNC_VERSION));
  auto* config =
      app.add_option("CONFIG", arguments.config, "Configuration file (TOML); runs the bus it describes");
  auto* check = app.add_option("--check", arguments.check,
                               "Check this configuration file, print its bus budget and start nothing")
                    ->type_name("FILE");
  app.add_option("--trace", arguments.trace,
                 "Log of the simulated bus in candump's format; --set sim.trace=FILE")
      ->type_name("FILE");
  app.add_option("--domain", arguments.domain, "DDS domain; --set dds.domain=NUMBER")->type_name("NUMBER");
  app.add_option("--set", arguments.set, "Option that wins over the file, e.g. --set bus.bit_rate=500000")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  app.add_flag("--print-default-config", arguments.print_default_config,
               "Print a configuration with every option");
  app.add_flag("--print-options-markdown", arguments.print_options_markdown,
               "Print the documentation of all options");
  config->excludes(check);
  app.footer(
      "Signals: SIGTERM and SIGINT stop, SIGHUP reads the file again, SIGUSR1 saves a flight recording.\n"
      "Exit codes: 0 stopped or file in order, 1 cannot start, 2 wrong command line, 78 wrong "
      "configuration.\n"
      "All options of the file: docs/configuration.md.");
}

std::vector<std::string> overrides(const Arguments& arguments) {
  std::vector<std::string> out = arguments.set;
  if (!arguments.trace.empty()) out.push_back("sim.trace=" + arguments.trace);
  if (!arguments.domain.empty()) out.push_back("dds.domain=" + arguments.domain);
  return out;
}

int print(const std::string& text) {
  return std::fputs(text.c_str(), stdout) >= 0 && std::fflush(stdout) == 0 ? exit_code::done
                                                                           : exit_code::cannot_start;
}

int run(const Arguments& arguments) {
  if (arguments.print_default_config) return print(default_config());
  if (arguments.print_options_markdown) return print(options_markdown());
  const bool check_only = !arguments.check.empty();
  const std::string& path = check_only ? arguments.check : arguments.config;
  if (path.empty()) {
    fmt::print(stderr, "cansyncd: no configuration file given\nusage: cansyncd CONFIG, or cansyncd --help\n");
    return exit_code::wrong_usage;
  }
  ConfigFile file = load_checked(path, overrides(arguments));
  if (!file.problems.empty()) {
    fmt::print(stderr, "{}", problems_text(file.problems));
    return exit_code::wrong_config;
  }
  if (check_only) {
    return print(fmt::format("{}: in order\n{}", path, budget_text(bus_budget(budget_input(file.config)))));
  }
  return run_daemon(std::move(file), overrides(arguments));
}

}  // namespace

int main(int argc, char** argv) {
  try {
    CLI::App app("CANsync master: drives one CANsync bus and offers it on DDS topics.", "cansyncd");
    Arguments arguments;
    describe(app, arguments);
    try {
      app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
      return app.exit(error) == 0 ? exit_code::done : exit_code::wrong_usage;
    }
    return run(arguments);
  } catch (const std::exception& error) {
    std::fputs("cansyncd: ", stderr);
    std::fputs(error.what(), stderr);
    std::fputs("\n", stderr);
    return exit_code::cannot_start;
  }
}
