#include "cansync_cluster/config/levels.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "config/shown.h"

namespace cansyncd {
namespace {

using config::Document;
using config::Node;
using config::Problem;
using config::Setting;
using config::Settings;

bool is_named(std::string_view key) {
  return key == "bus.name" || key == "dds.partition";
}

/// Why the level does not take the option; empty: it does.
std::string refusal(const LevelOptions& level, const Setting& setting) {
  const std::string_view key = setting.option->key;
  if (key == "bus.protocol" || level.common.find(key) != nullptr)
    return fmt::format("found below {}; allowed: as {}, because both buses have it together", level.name,
                       key);
  const auto excluded = std::ranges::find(level.excluded, key, &LevelOptions::Excluded::key);
  if (excluded == level.excluded.end()) return {};
  return fmt::format("found {}; allowed: nothing, because {}", config::shown(setting.value.text),
                     excluded->why);
}

void add_common(const Setting& common, const LevelOptions& level, Settings& settings) {
  const config::Option* option = level.table.find(common.option->key);
  if (option == nullptr || option->key == "bus.protocol") return;
  Setting setting = common;
  setting.option = option;
  if (is_named(option->key))
    setting.value =
        config::scalar_value(fmt::format("{}.{}", *config::scalar<std::string>(common.value), level.name));
  settings.items.push_back(std::move(setting));
}

}  // namespace

Document take_level(Document& document, std::string_view name) {
  const auto belongs = [&](const Node& node) { return node.path.front().name == name; };
  Document level;
  std::ranges::copy_if(document.nodes, std::back_inserter(level.nodes), belongs);
  std::erase_if(document.nodes, belongs);
  for (const Node& node : level.nodes) {
    const bool section = node.kind == Node::Kind::section && node.path.front().index < 0;
    if (node.path.size() == 1 && !section)
      level.problems.push_back(
          {node.key, std::string(name),
           fmt::format("found no section; allowed: sections below it, as [{}.bus]", name)});
  }
  if (!level.problems.empty()) level.nodes.clear();
  std::erase_if(level.nodes, [](const Node& node) { return node.path.size() == 1; });
  for (Node& node : level.nodes) node.path.erase(node.path.begin());
  return level;
}

Settings level_settings(const Document& document, const LevelOptions& level,
                        std::span<const std::string> overrides, const std::vector<Setting>& common,
                        const std::string& bus) {
  Settings settings = config::resolve(document, level.table);
  const std::string prefix = fmt::format("{}.", level.name);
  for (const std::string& assignment : overrides) {
    if (!assignment.starts_with(prefix)) continue;
    const std::size_t before = settings.problems.size();
    config::override_setting(settings, assignment.substr(prefix.size()), level.table);
    const std::string place = "--set " + assignment;
    if (settings.problems.size() > before) settings.problems.back().where.file = place;
    if (!settings.items.empty() && settings.items.back().overridden) settings.items.back().where.file = place;
  }
  std::erase_if(settings.items, [&](const Setting& setting) {
    std::string why = refusal(level, setting);
    if (why.empty()) return false;
    settings.problems.push_back({setting.where, setting.key, std::move(why)});
    return true;
  });
  for (const Setting& setting : common) add_common(setting, level, settings);
  const auto named = [](const Setting& setting) { return setting.option->key == "bus.name"; };
  if (std::ranges::none_of(settings.items, named)) {
    Setting name;
    name.option = level.table.find("bus.name");
    name.key = name.option->key;
    name.value = config::scalar_value(fmt::format("{}.{}", bus, level.name));
    settings.items.push_back(std::move(name));
  }
  return settings;
}

void name_level(std::vector<Problem>& problems, const LevelOptions& level) {
  for (Problem& problem : problems) {
    const bool whole = problem.key.empty() || problem.key == level.name;
    if (!whole && level.common.find(problem.key) == nullptr)
      problem.key = fmt::format("{}.{}", level.name, problem.key);
  }
}

}  // namespace cansyncd
