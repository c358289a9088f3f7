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

/// Sections that are replaced together with another one.
std::set<std::string, std::less<>> with_their_pair(std::set<std::string, std::less<>> names) {
  constexpr std::pair<std::string_view, std::string_view> kPairs[] = {{"receive", "filter"},
                                                                      {"mapping", "mapped"}};
  for (const auto& [one, other] : kPairs) {
    if (names.count(one) == 0 && names.count(other) == 0) continue;
    names.emplace(one);
    names.emplace(other);
  }
  return names;
}

std::string section_of(std::string_view key) {
  return std::string(key.substr(0, key.find('.')));
}

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
  std::set<std::string, std::less<>> named;
  for (const config::Node& node : document.nodes) named.insert(node.path.front().name);
  const auto replaced = with_their_pair(named);
  config::Settings wanted = config::resolve(document, layer2_options());
  for (const config::Setting& setting : settings_) {
    if (replaced.count(section_of(setting.key)) == 0) wanted.items.push_back(setting);
  }
  Layer2File file = build_layer2_config(std::move(wanted), kText);
  if (!file.problems.empty()) {
    problem = text_of(file.problems);
    return nullptr;
  }
  auto prepared = std::make_shared<PreparedConfiguration>(PreparedConfiguration{
      file.config, std::move(file.settings), layer2::PreparedSettings(module_settings(file.config))});
  for (const ChangingSection& section : kChangingSections) {
    if (replaced.count(section.name) != 0) prepared->module.parts.*section.part = true;
  }
  under_way_ = prepared;
  return prepared;
}

void RunningConfiguration::adopt(const PreparedConfiguration& prepared) {
  ++changes_;
  config_ = prepared.config;
  settings_ = prepared.settings;
}

}  // namespace cansyncd
