#include "cansync/config/file.h"

#include <algorithm>
#include <utility>

#include "cansync/config/check.h"
#include "cansync/config/options.h"
#include "config/document.h"
#include "daemon_config/check_daemon.h"

namespace cansyncd {
namespace {

/// The bus and its slaves first, then their names, then what may name a slave; what a slave gives comes after
/// the defaults for all slaves.
int phase(const Setting& setting) {
  if (setting.option->key == "bus.interface" || setting.option->key == "slave.number") return 0;
  if (setting.option->key == "slave.name") return 1;
  return slave_of(setting) ? 3 : 2;
}

bool given(const std::vector<Setting>& settings, std::string_view key) {
  return std::any_of(settings.begin(), settings.end(),
                     [&](const Setting& setting) { return setting.option->key == key; });
}

/// Defaults that follow from other options.
void apply_derived_of_line(Config& config, const std::vector<Setting>& settings) {
  if (!given(settings, "bus.send_margin_us")) {
    config.master.send_margin = cansync::default_send_margin(config.master.bit_rate);
  }
  const cansync::SlaveMask configured = config.master.configured();
  if (!given(settings, "sim.drives")) config.drives.slaves = configured;
  if (given(settings, "process.maximum_slave")) return;
  for (const cansync::SlaveNumber slave : configured) config.master.process.maximum_slave = slave;
}

/// A simulated line of which no slave is given has every one. Each configured slave gets its default name.
void complete_line(Config& config) {
  if (config.bus.kind == BusKind::simulated && config.master.configured().empty()) {
    for (cansync::SlaveSettings& slave : config.master.slaves) slave.configured = true;
  }
  for (unsigned n = 0; n < cansync::kSlaves; ++n) {
    if (config.master.slaves[n].configured) config.slaves[n].name = "slave" + std::to_string(n);
  }
}

/// The value number of an option of [[slave.value]], [[actual]] or [[reference]]; else 0.
unsigned number_of_value(const Setting& setting) {
  if (setting.numbers.empty() || setting.option->section() == "slave") return 0;
  return static_cast<unsigned>(setting.numbers.back());
}

void apply_settings(Draft& draft, const std::vector<Setting>& settings, std::vector<Problem>& problems) {
  bool named = false;
  for (const Setting& setting : settings) {
    if (!named && phase(setting) > 0) {
      complete_line(draft.config);
      named = true;
    }
    const std::optional<unsigned> slave = slave_of(setting);
    draft.slave = slave.value_or(0);
    draft.value = number_of_value(setting);
    if (slave && phase(setting) > 0 && !draft.config.master.slaves[*slave].configured) {
      problems.push_back({setting.where, setting.key,
                          "no [[slave]] has this number; allowed: numbers of configured slaves"});
    } else if (auto text = option_rows().apply(*setting.option, setting.value, draft)) {
      problems.push_back({setting.where, setting.key, std::move(*text)});
    }
  }
  if (!named) complete_line(draft.config);
}

}  // namespace

std::optional<unsigned> slave_of(const Setting& setting) {
  if (!setting.option->key.starts_with("slave.")) return std::nullopt;
  return static_cast<unsigned>(setting.numbers.front());
}

ConfigFile build_config(Settings settings, const std::string& path) {
  std::stable_sort(settings.items.begin(), settings.items.end(),
                   [](const Setting& a, const Setting& b) { return phase(a) < phase(b); });
  ConfigFile file;
  file.path = path;
  file.problems = std::move(settings.problems);
  Draft draft;
  apply_settings(draft, settings.items, file.problems);
  apply_derived(draft.config, settings.items);
  apply_derived_of_line(draft.config, settings.items);
  // With wrong values the cross-checks would only complain about what is missing because of them.
  if (file.problems.empty()) file.problems = check_and_finish(draft, settings.items, path);
  config::sort_by_place(file.problems);
  file.profile_problems = std::move(draft.profile_problems);
  file.config = std::move(draft.config);
  file.settings = std::move(settings.items);
  return file;
}

ConfigFile load_config(const config::Source& source, std::span<const std::string> overrides) {
  return build_config(config::read_settings(source, overrides, options()), source.path);
}

}  // namespace cansyncd
