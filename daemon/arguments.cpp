#include "daemon/arguments.h"

#include <CLI/CLI.hpp>
#include <string>
#include <utility>

#include "text/build_info.h"

namespace cansyncd {
namespace {

void describe(CLI::App& app, Arguments& arguments) {
  app.set_version_flag("--version", "cansyncd " + std::string(text::build_text()));
  auto* config = app.add_option("CONFIG", arguments.config,
                                "Configuration files (TOML); runs the bus that each describes");
  auto* check =
      app.add_option("--check", arguments.check,
                     "Check these configuration files, each and together, print their bus budgets and "
                     "start nothing")
          ->type_name("FILE");
  auto* dbc = app.add_option("--print-dbc", arguments.dbc,
                             "Print the bus of this configuration file as a DBC file, for other CAN tools")
                  ->type_name("FILE");
  auto* last_good =
      app.add_option(
             "--last-good", arguments.last_good,
             "Keep each configuration that has run in this folder, and start with the newest right one "
             "when CONFIG is wrong")
          ->type_name("DIR");
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
  app.add_flag("--print-options-man", arguments.print_options_man,
               "Print the options' part of the man page cansync.toml(5)");
  config->excludes(check);
  last_good->excludes(check)->excludes(dbc);
  config->excludes(dbc);
  check->excludes(dbc);
  app.footer(
      "Signals: SIGTERM and SIGINT stop, SIGHUP reads the file again, SIGUSR1 saves a flight recording.\n"
      "Exit codes: 0 stopped or file in order, 1 cannot start, 2 wrong command line, 78 wrong "
      "configuration.\n"
      "All options of the file: docs/configuration.md.");
}

}  // namespace

std::variant<Arguments, CommandLineEnd> parse_arguments(int argc, const char* const* argv) {
  CLI::App app("Gateway between CAN buses and DDS topics.", "cansyncd");
  Arguments arguments;
  describe(app, arguments);
  if (auto end = text::read_command_line(app, argc, argv)) return *std::move(end);
  const bool prints = arguments.print_default_config || arguments.print_options_markdown ||
                      arguments.print_options_man || !arguments.dbc.empty();
  if (arguments.config.empty() && arguments.check.empty() && !prints) {
    return CommandLineEnd{
        true, "cansyncd: no configuration file given\nusage: cansyncd CONFIG, or cansyncd --help\n"};
  }
  if (!arguments.trace.empty() && arguments.config.size() > 1) {
    return CommandLineEnd{true,
                          "cansyncd: --trace is for one configuration file; with several, give each its own "
                          "option sim.trace (cansyncd --help)\n"};
  }
  return arguments;
}

std::vector<std::string> overrides(const Arguments& arguments) {
  std::vector<std::string> out = arguments.set;
  if (!arguments.trace.empty()) out.push_back("sim.trace=" + arguments.trace);
  if (!arguments.domain.empty()) out.push_back("dds.domain=" + arguments.domain);
  return out;
}

}  // namespace cansyncd
