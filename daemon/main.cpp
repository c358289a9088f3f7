#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "daemon/arguments.h"
#include "daemon/configuration.h"
#include "daemon/daemon.h"
#include "daemon/kept_configurations.h"
#include "daemon/protocols.h"
#include "daemon/service/service_log.h"
#include "text/visible.h"

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

/// The file; when it is wrong, and configurations that have run are kept, the newest of these that is right.
LoadedConfig choose(LoadedConfig file, const Continuity& continuity) {
  if (file.problems.empty()) return file;
  for (KeptConfiguration& kept : continuity.kept.of(file.path)) {
    LoadedConfig good = continuity.load({file.path, std::move(kept.text)});
    if (!good.problems.empty()) continue;
    tell_wrong_configuration(good.daemon.bus.name, file.problems);
    good.kept_since = std::move(kept.since);
    return good;
  }
  return file;
}

/// What is not wrong and still leads to trouble; lines that end with a line feed.
std::string advice(const LoadedConfig& file) {
  std::string text;
  for (const DaemonConfig& config : file.served()) {
    const bool on_network = config.dds.interface != "lo" && config.dds.xml.empty();
    if (!on_network || config.bus.kind == BusKind::simulated || config.bus.name != config.bus.interface)
      continue;
    text += fmt::format(
        "warning: bus.name is \"{0}\", the name of the CAN interface, and dds.interface is \"{1}\": another "
        "computer on that network may have a bus of this name, and then clients there reach one of the two alone; "
        "set bus.name, for example \"press2-{0}\"\n",
        config.bus.name, config.dds.interface);
  }
  return text;
}

int run(const Arguments& arguments) {
  const std::vector<std::string> settings = overrides(arguments);
  if (arguments.print_default_config) return print(print_default_config(settings, protocols()));
  if (arguments.print_options_markdown) return print(print_options_markdown(protocols()));
  if (arguments.print_options_man) return print(print_options_man(protocols()));
  if (!arguments.dbc.empty()) return print_dbc(arguments.dbc, settings);
  const bool check_only = !arguments.check.empty();
  const Continuity continuity{
      [&settings](const config::Source& source) { return load_configuration(source, settings, protocols()); },
      KeptConfigurations(arguments.last_good)};
  std::vector<LoadedConfig> files;
  for (const std::string& path : check_only ? arguments.check : arguments.config)
    files.push_back(choose(continuity.load(path), continuity));
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
  for (const LoadedConfig& file : files) {
    tell(file.daemon.bus.name, file.problems);
    if (!check_only) continue;
    tell(file.daemon.bus.name, file.profile_problems);
    tell(file.daemon.bus.name, file.script_problems);
  }
  if (end == exit_code::done) tell(files.front().daemon.bus.name, check_together(files));
  // A service that starts looks at the adapter of its own interface; what else is plugged in keeps it from
  // nothing.
  if (end == exit_code::done && check_only)
    tell(files.front().daemon.bus.name, check_adapters(files, can::adapters_there()));
  if (end != exit_code::done) return end;
  if (!check_only) return run_daemon(files, settings, continuity);
  for (const LoadedConfig& file : files) {
    const std::string said = fmt::format("{}: in order\n{}{}", file.path, file.check_text, advice(file));
    end = print(text::visible(said, "\n\t"));
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
    std::fputs(text::visible(error.what(), "\n\t").c_str(), stderr);
    std::fputs("\n", stderr);
    return exit_code::cannot_start;
  }
}
