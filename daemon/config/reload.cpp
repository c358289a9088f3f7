#include "daemon/config/reload.h"

#include <map>
#include <set>
#include <utility>

namespace cansyncd {
namespace {

using ByKey = std::map<std::string, const Setting*>;

ByKey by_key(const std::vector<Setting>& settings) {
  ByKey out;
  for (const Setting& setting : settings) out.emplace(setting.key(), &setting);
  return out;
}

/// Does the option take effect while running? What a slave, that only one of the two files has, gives does
/// not: the set of slaves needs a restart.
bool applies(const Setting& setting, const Config& running, const Config& wanted) {
  if (!setting.option->reload) return false;
  if (setting.slave < 0) return true;
  const auto slave = static_cast<std::size_t>(setting.slave);
  return running.master.slaves[slave].configured && wanted.master.slaves[slave].configured;
}

std::string text_of(const ByKey& settings, const std::string& key, const Option& option) {
  const auto found = settings.find(key);
  return found == settings.end() ? std::string(option.initial) : found->second->value.text;
}

/// Numbers of [[slave.value]], [[actual]] and [[reference]] mean nothing by themselves.
bool is_value_number(const Option& option) {
  return option.key.ends_with(".number") && option.key != "slave.number";
}

}  // namespace

ReloadPlan plan_reload(const ConfigFile& running, const ConfigFile& wanted) {
  const ByKey before = by_key(running.settings);
  const ByKey after = by_key(wanted.settings);
  ReloadPlan plan;
  std::map<std::string, const Setting*> all = before;
  all.insert(after.begin(), after.end());
  for (const auto& [key, setting] : all) {
    if (is_value_number(*setting->option)) continue;
    if (text_of(before, key, *setting->option) == text_of(after, key, *setting->option)) continue;
    const bool now = applies(*setting, running.config, wanted.config);
    (now ? plan.applied : plan.needs_restart).push_back(key);
  }
  Settings merged;
  for (const Setting& setting : running.settings) {
    if (!applies(setting, running.config, wanted.config)) merged.items.push_back(setting);
  }
  for (const Setting& setting : wanted.settings) {
    if (applies(setting, running.config, wanted.config)) merged.items.push_back(setting);
  }
  plan.merged = build_config(std::move(merged), wanted.path);
  return plan;
}

}  // namespace cansyncd
