#include "layer2/config/running.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "config/document.h"
#include "layer2/config/module_settings.h"
#include "layer2/config/options.h"

namespace cansyncd {
namespace {

using Parts = layer2::PreparedSettings::Parts;

/// What positions name in place of a file.
constexpr const char* kText = "data";

/// Sections that change while the daemon runs, and what of the module they belong to. Those of one part are
/// replaced together.
struct ChangingSection {
  std::string_view name;
  bool Parts::*part;
};
constexpr auto kChangingSections = std::to_array<ChangingSection>({{"send", &Parts::station},
                                                                   {"receive", &Parts::station},
                                                                   {"filter", &Parts::station},
                                                                   {"queue", &Parts::receive_queues},
                                                                   {"timer", &Parts::timers},
                                                                   {"object", &Parts::objects},
                                                                   {"window", &Parts::window},
                                                                   {"script", &Parts::scripts},
                                                                   {"mapping", &Parts::mapping},
                                                                   {"mapped", &Parts::mapping}});

std::string_view section_of(std::string_view key) {
  return key.substr(0, key.find('.'));
}

/// What a text names.
struct Named {
  explicit Named(const config::Document& document, const config::Settings& wanted) {
    for (const config::Node& node : document.nodes) sections.emplace(node.path.front().name);
    for (const config::Setting& setting : wanted.items) keys.insert(setting.key);
    const auto in_mapping = [](const std::string& key) { return section_of(key) == "mapping"; };
    ends_mapping = sections.count("mapping") != 0 && sections.count("mapped") == 0 &&
                   std::none_of(keys.begin(), keys.end(), in_mapping);
  }
  /// A setting in force does not count any more.
  bool replaces(const config::Setting& setting) const {
    const std::string_view section = section_of(setting.key);
    if (section == "mapped" && ends_mapping) return true;
    // Ranges and node filter are alternatives.
    if (section == "filter" && sections.count("receive") != 0) return true;
    if (!setting.numbers.empty()) return sections.count(section) != 0;
    return keys.count(setting.key) != 0;
  }

  std::set<std::string, std::less<>> sections;
  std::set<std::string, std::less<>> keys;
  bool ends_mapping = false;  ///< [mapping] without anything in it, and no table
};

std::string text_of(const std::vector<config::Problem>& problems) {
  std::string text = config::to_string(problems.front());
  if (problems.size() > 1) text += fmt::format(" (and {} more)", problems.size() - 1);
  return text;
}

/// Of the first section that does not change; empty: none.
std::string not_changeable(const config::Document& document) {
  for (const config::Node& node : document.nodes) {
    const std::string& name = node.path.front().name;
    const auto found = std::find_if(kChangingSections.begin(), kChangingSections.end(),
                                    [&](const ChangingSection& section) { return section.name == name; });
    if (found != kChangingSections.end()) continue;
    std::string allowed;
    for (const ChangingSection& section : kChangingSections)
      allowed += fmt::format("{}{}", allowed.empty() ? "" : ", ", section.name);
    const config::Problem problem{
        node.key, name, fmt::format("this does not change while the daemon runs; allowed: {}", allowed)};
    return config::to_string(problem);
  }
  return {};
}

}  // namespace

std::shared_ptr<PreparedConfiguration> RunningConfiguration::prepare(std::string_view toml,
                                                                     std::string& problem) {
  const config::Document document = config::parse_document(toml, kText);
  if (!document.problems.empty()) {
    problem = text_of(document.problems);
    return nullptr;
  }
  problem = not_changeable(document);
  if (!problem.empty()) return nullptr;
  config::Settings wanted = config::resolve(document, layer2_options());
  const Named named(document, wanted);
  for (const config::Setting& setting : settings_) {
    if (!named.replaces(setting)) wanted.items.push_back(setting);
  }
  Layer2File file = build_layer2_config(std::move(wanted), kText);
  if (!file.problems.empty()) {
    problem = text_of(file.problems);
    return nullptr;
  }
  auto prepared = std::make_shared<PreparedConfiguration>(PreparedConfiguration{
      file.config, std::move(file.settings), layer2::PreparedSettings(module_settings(file.config))});
  for (const ChangingSection& section : kChangingSections) {
    if (named.sections.count(section.name) != 0) prepared->module.parts.*section.part = true;
  }
  under_way_ = prepared;
  return prepared;
}

void RunningConfiguration::adopt(const PreparedConfiguration& prepared) {
  ++changes_;
  if (prepared.module.parts.mapping) ++tables_;
  config_ = prepared.config;
  settings_ = prepared.settings;
}

}  // namespace cansyncd
