#include "daemon/config/file.h"

#include <algorithm>
#include <iterator>
#include <tuple>
#include <utility>

#include "daemon/config/check.h"

namespace cansyncd {
namespace {

/// Slaves first, then their names, then what may name a slave; what a slave gives comes after the defaults
/// for all slaves.
int phase(const Setting& setting) {
  if (setting.option->key == "slave.number") return 0;
  if (setting.option->key == "slave.name") return 1;
  return setting.slave < 0 ? 2 : 3;
}

bool given(const std::vector<Setting>& settings, std::string_view key) {
  return std::any_of(settings.begin(), settings.end(),
                     [&](const Setting& setting) { return setting.option->key == key; });
}

void apply_defaults(Draft& draft) {
  for (const Option& option : options()) {
    const std::string_view section = option.key.substr(0, option.key.rfind('.'));
    if (!option.has_initial() || is_repeated(section)) continue;  // repeated ones: defaults of the struct
    option.apply(draft, *parse_value(std::string(option.initial)));
  }
}

/// Defaults that follow from other options.
void apply_derived(Config& config, const std::vector<Setting>& settings) {
  if (!given(settings, "bus.name")) config.bus.name = config.bus.interface;
  if (!given(settings, "dds.partition")) config.dds.partition = config.bus.name;
  if (!given(settings, "bus.send_margin_us")) {
    config.master.send_margin = cansync::default_send_margin(config.master.bit_rate);
  }
  const cansync::SlaveMask configured = config.master.configured();
  if (!given(settings, "sim.drives")) config.sim.drives = configured;
  if (given(settings, "process.maximum_slave")) return;
  for (unsigned n = 0; n < cansync::kSlaves; ++n) {
    const auto slave = *cansync::SlaveNumber::from(n);
    if (configured.has(slave)) config.master.process.maximum_slave = slave;
  }
}

void name_slaves(Config& config) {
  for (unsigned n = 0; n < cansync::kSlaves; ++n) {
    if (config.master.slaves[n].configured) config.slaves[n].name = "slave" + std::to_string(n);
  }
}

void apply_settings(Draft& draft, const std::vector<Setting>& settings, std::vector<Problem>& problems) {
  bool named = false;
  for (const Setting& setting : settings) {
    if (!named && phase(setting) > 0) {
      name_slaves(draft.config);
      named = true;
    }
    draft.slave = static_cast<unsigned>(std::max(setting.slave, 0));
    draft.value = static_cast<unsigned>(std::max(setting.value_index, 0));
    if (setting.slave >= 0 && phase(setting) > 0 && !draft.config.master.slaves[draft.slave].configured) {
      problems.push_back({setting.where, setting.key(),
                          "no [[slave]] has this number; allowed: numbers of configured slaves"});
    } else if (auto text = mismatch(*setting.option, setting.value, draft)) {
      problems.push_back({setting.where, setting.key(), std::move(*text)});
    } else {
      setting.option->apply(draft, setting.value);
    }
  }
  if (!named) name_slaves(draft.config);
}

}  // namespace

ConfigFile build_config(Settings settings, const std::string& path) {
  std::stable_sort(settings.items.begin(), settings.items.end(),
                   [](const Setting& a, const Setting& b) { return phase(a) < phase(b); });
  ConfigFile file;
  file.path = path;
  file.problems = std::move(settings.problems);
  Draft draft;
  apply_defaults(draft);
  apply_settings(draft, settings.items, file.problems);
  apply_derived(draft.config, settings.items);
  // With wrong values the cross-checks would only complain about what is missing because of them.
  if (file.problems.empty()) file.problems = check_and_finish(draft, settings.items, path);
  std::stable_sort(file.problems.begin(), file.problems.end(), [](const Problem& a, const Problem& b) {
    return std::tie(a.where.line, a.where.column) < std::tie(b.where.line, b.where.column);
  });
  file.config = std::move(draft.config);
  file.settings = std::move(settings.items);
  return file;
}

ConfigFile load_config(const std::string& path, std::span<const std::string> overrides) {
  const Document document = read_document(path);
  Settings settings = resolve(document);
  for (const std::string& assignment : overrides) override_setting(settings, assignment);
  return build_config(std::move(settings), path);
}

std::string problems_text(const std::vector<Problem>& problems) {
  std::string out;
  for (std::size_t i = 0; i < std::min(problems.size(), kProblemsShown); ++i) {
    out += to_string(problems[i]) + "\n";
  }
  if (problems.size() > kProblemsShown) {
    out += "and " + std::to_string(problems.size() - kProblemsShown) + " more problems\n";
  }
  return out;
}

}  // namespace cansyncd
