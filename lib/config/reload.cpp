#include "config/reload.h"

#include <map>
#include <string_view>

namespace config {
namespace {

using ByKey = std::map<std::string_view, const Setting*>;

ByKey by_key(const std::vector<Setting>& settings) {
  ByKey out;
  for (const Setting& setting : settings) out.emplace(setting.key, &setting);
  return out;
}

std::string_view text_of(const ByKey& settings, std::string_view key, const Option& option) {
  const auto found = settings.find(key);
  return found == settings.end() ? option.initial : std::string_view(found->second->value.text);
}

}  // namespace

Changes compare(const std::vector<Setting>& running, const std::vector<Setting>& wanted,
                const std::function<bool(const Setting&)>& applies) {
  return replace(running, wanted,
                 [&](const Setting& setting) { return setting.option->reload && applies(setting); });
}

Changes replace(const std::vector<Setting>& running, const std::vector<Setting>& wanted,
                const std::function<bool(const Setting&)>& now) {
  const ByKey before = by_key(running);
  const ByKey after = by_key(wanted);
  ByKey all = before;
  all.insert(after.begin(), after.end());
  Changes changes;
  for (const auto& [key, setting] : all) {
    const Option& option = *setting->option;
    if (option.label || text_of(before, key, option) == text_of(after, key, option)) continue;
    (now(*setting) ? changes.applied : changes.needs_restart).emplace_back(key);
  }
  for (const Setting& setting : running) {
    if (!now(setting)) changes.merged.items.push_back(setting);
  }
  for (const Setting& setting : wanted) {
    if (now(setting)) changes.merged.items.push_back(setting);
  }
  return changes;
}

}  // namespace config
