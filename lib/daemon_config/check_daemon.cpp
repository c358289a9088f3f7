#include "daemon_config/check_daemon.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>

#include "can/adapter/adapter.h"
#include "daemon_config/bit_timing_check.h"

namespace cansyncd {
namespace {

bool given(const std::vector<config::Setting>& settings, std::string_view key) {
  for (const config::Setting& setting : settings) {
    if (setting.option->key == key) return true;
  }
  return false;
}

void check_fault_file(std::string& script, Findings& findings) {
  if (script.empty()) return;
  findings.finish_path("sim.fault_script", script);
  std::error_code error;
  if (std::filesystem::is_regular_file(script, error) && std::ifstream(script)) return;
  findings.problem("sim.fault_script",
                   fmt::format("found \"{}\", which cannot be read; allowed: a readable file", script));
}

/// Combinations of output and input that make no sense.
void check_sync(const SyncConfig& sync, Findings& findings) {
  if (sync.output == SyncOutput::phc && sync.input != SyncInput::none) {
    findings.problem("sync.input",
                     "found an input beside output = \"phc\"; allowed: \"none\", because the timeline "
                     "follows the hardware clock (let PTP discipline that clock instead)");
  }
  if (sync.output == SyncOutput::can && sync.input == SyncInput::can) {
    findings.problem("sync.input",
                     "found \"can\" beside output = \"can\"; allowed: only one of them, because one bus "
                     "carries one software SYNC");
  }
  if (sync.output == SyncOutput::gpio && sync.input == SyncInput::gpio &&
      sync.gpio_chip == sync.input_gpio_chip && sync.gpio_line == sync.input_gpio_line) {
    findings.problem("sync.input_gpio_line",
                     fmt::format("found {} of {}, which is the output; allowed: another line",
                                 sync.input_gpio_line, sync.input_gpio_chip));
  }
}

void check_adapter(const BusConfig& bus, Findings& findings) {
  if (bus.adapter.empty()) return;
  if (bus.kind == BusKind::simulated) {
    findings.problem("bus.adapter",
                     fmt::format("found \"{}\" for the simulated line; allowed: none, or a CAN network "
                                 "interface as bus.interface",
                                 bus.adapter));
    return;
  }
  if (const std::string problem = can::read_pin(bus.adapter).problem; !problem.empty())
    findings.problem("bus.adapter", problem + "; `cansync scan INTERFACE` shows the adapter of an interface");
}

}  // namespace

Findings::Findings(const std::vector<config::Setting>& settings, const std::string& path) : path_(path) {
  for (const config::Setting& setting : settings) places_.emplace(setting.key, &setting);
}

const config::Setting* Findings::place(const std::string& key) const {
  const auto found = places_.find(key);
  return found == places_.end() ? nullptr : found->second;
}

config::Problem Findings::at(const std::string& key, std::string text) const {
  const config::Setting* setting = place(key);
  return {setting != nullptr ? setting->where : config::Position{path_, 0, 0}, key, std::move(text)};
}

void Findings::problem(const std::string& key, std::string text) {
  problems_.push_back(at(key, std::move(text)));
}

void Findings::finish_path(const std::string& key, std::string& path) const {
  const config::Setting* setting = place(key);
  if (path.empty() || setting == nullptr || setting->overridden) return;
  const std::filesystem::path file = path;
  if (file.is_relative()) path = (std::filesystem::path(path_).parent_path() / file).string();
}

void apply_derived(DaemonConfig& config, const std::vector<config::Setting>& settings) {
  if (!given(settings, "bus.name")) config.bus.name = config.bus.interface;
  if (!given(settings, "dds.partition")) config.dds.partition = config.bus.name;
}

void check_daemon(DaemonConfig& config, Findings& findings) {
  check_fault_file(config.sim.fault_script, findings);
  findings.finish_path("dds.security", config.dds.security);
  findings.finish_path("metrics.file", config.metrics.file);
  check_sync(config.sync, findings);
  check_adapter(config.bus, findings);
  if (const auto wrong = check_bit_timing(config.bus)) findings.problem(wrong->option, wrong->text);
}

}  // namespace cansyncd
