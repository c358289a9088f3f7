#include "daemon/config/settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <optional>
#include <set>
#include <utility>

namespace cansyncd {
namespace {

using Path = std::vector<Node::Step>;

/// "slave.value.name"
std::string generic_key(const Path& path) {
  std::string out;
  for (const Node::Step& step : path) out += (out.empty() ? "" : ".") + step.name;
  return out;
}

/// "slave[0].value[1]": tells one section from its neighbours.
std::string section_id(const Path& path, std::size_t steps) {
  std::string out;
  for (std::size_t i = 0; i < steps; ++i) out += fmt::format("{}[{}].", path[i].name, path[i].index);
  return out;
}

/// "[bus]", "[[slave]]"
std::string brackets(std::string_view section) {
  return is_repeated(section) ? fmt::format("[[{}]]", section) : fmt::format("[{}]", section);
}

std::string sections_text() {
  std::string out;
  std::set<std::string_view> seen;
  for (const Option& option : options()) {
    const std::string_view section = option.key.substr(0, option.key.rfind('.'));
    if (!seen.insert(section).second) continue;
    if (!out.empty()) out += ", ";
    out += brackets(section);
  }
  return out;
}

std::string options_text(std::string_view section) {
  std::string out;
  for (const Option& option : options()) {
    const std::size_t dot = option.key.rfind('.');
    if (option.key.substr(0, dot) != section) continue;
    if (!out.empty()) out += ", ";
    out += option.key.substr(dot + 1);
  }
  return out;
}

std::string unknown_option_text(std::string_view key) {
  const std::size_t dot = key.rfind('.');
  const std::string_view section = dot == std::string_view::npos ? "" : key.substr(0, dot);
  if (section.empty() || !is_section(section)) {
    return "no such option; allowed sections: " + sections_text();
  }
  return fmt::format("no such option; allowed in this section: {}", options_text(section));
}

std::string section_form(std::string_view section) {
  return (is_repeated(section) ? "sections " : "one section ") + brackets(section);
}

std::optional<int> small_number(const Value& value, const Option& option) {
  const auto* number = scalar<std::int64_t>(value);
  if (number == nullptr || *number < option.minimum || *number > option.maximum) return std::nullopt;
  return static_cast<int>(*number);
}

/// Walks through a document once and collects settings and problems.
class Resolver {
 public:
  explicit Resolver(const Document& document) : document_(document) {}

  Settings run() {
    settings_.problems = document_.problems;
    find_numbers();
    for (const Node& node : document_.nodes) {
      if (skipped(node)) continue;
      if (node.kind == Node::Kind::value) {
        value(node);
      } else {
        section(node);
      }
    }
    return std::move(settings_);
  }

 private:
  void problem(const Position& where, std::string key, std::string text) {
    settings_.problems.push_back({where, std::move(key), std::move(text)});
  }

  /// Which number each [[slave]], [[slave.value]] and [[reference]] has.
  void find_numbers() {
    for (const Node& node : document_.nodes) {
      if (node.kind != Node::Kind::value || node.path.size() < 2 || node.path.back().name != "number")
        continue;
      const std::string section = section_id(node.path, node.path.size() - 1);
      const Option* option = find_option(generic_key(node.path));
      if (option == nullptr || node.path[node.path.size() - 2].index < 0) continue;
      numbers_[section] = {small_number(node.value, *option), node.where};
    }
  }

  bool skipped(const Node& node) const {
    for (std::size_t steps = 1; steps <= node.path.size(); ++steps) {
      Path whole_array(node.path.begin(), node.path.begin() + static_cast<std::ptrdiff_t>(steps));
      whole_array.back().index = -1;
      if (skip_.contains(section_id(node.path, steps)) || skip_.contains(section_id(whole_array, steps))) {
        return true;
      }
    }
    return false;
  }

  void skip(const Node& node) { skip_.insert(section_id(node.path, node.path.size())); }

  void section(const Node& node) {
    const std::string key = generic_key(node.path);
    const bool many = node.kind == Node::Kind::sections || node.path.back().index >= 0;
    if (const Option* option = find_option(key)) {
      problem(node.key, key, fmt::format("found a section; allowed: {}", allowed(*option)));
      skip(node);
    } else if (!is_section(key)) {
      problem(node.key, key, "no such section; allowed: " + sections_text());
      skip(node);
    } else if (many != is_repeated(key)) {
      problem(node.key, key,
              fmt::format("found {} brackets; allowed: {}", many ? "double" : "single", section_form(key)));
      skip(node);
    } else if (node.kind == Node::Kind::section && many) {
      numbered_section(node, key);
    }
  }

  void numbered_section(const Node& node, const std::string& key) {
    const std::string id = section_id(node.path, node.path.size());
    const Option& option = *find_option(key + ".number");
    const auto found = numbers_.find(id);
    if (found == numbers_.end()) {
      problem(node.where, key + ".number", "missing; allowed: " + allowed(option));
      skip(node);
      return;
    }
    const auto& [number, where] = found->second;
    if (!number) {
      const auto value = std::find_if(document_.nodes.begin(), document_.nodes.end(), [&](const Node& other) {
        return other.kind == Node::Kind::value && generic_key(other.path) == key + ".number" &&
               section_id(other.path, other.path.size() - 1) == id;
      });
      problem(where, key + ".number",
              fmt::format("found {}; allowed: {}", value->value.text, allowed(option)));
      skip(node);
      return;
    }
    const std::string place = section_id(node.path, node.path.size() - 1) + key + std::to_string(*number);
    const auto [first, fresh] = used_.emplace(place, where.line);
    if (fresh) return;
    problem(where, key + ".number",
            fmt::format("found {}, which line {} has already; allowed: each number once", *number,
                        first->second));
    skip(node);
  }

  void value(const Node& node) {
    const std::string key = generic_key(node.path);
    const Option* option = find_option(key);
    if (option == nullptr) {
      problem(node.key, key,
              is_section(key) ? fmt::format("found {}; allowed: {}", node.value.text, section_form(key))
                              : unknown_option_text(key));
      return;
    }
    Setting setting;
    setting.option = option;
    setting.value = node.value;
    setting.where = node.where;
    for (std::size_t steps = 1; steps < node.path.size(); ++steps) {
      const auto number = numbers_.find(section_id(node.path, steps));
      if (number == numbers_.end()) continue;
      const bool is_slave = node.path[steps - 1].name == "slave";
      (is_slave ? setting.slave : setting.value_index) = *number->second.first;
    }
    settings_.items.push_back(std::move(setting));
  }

  const Document& document_;
  Settings settings_;
  std::map<std::string, std::pair<std::optional<int>, Position>> numbers_;
  std::map<std::string, std::uint32_t> used_;
  std::set<std::string> skip_;
};

/// A key of --set taken apart: "slave.3.name" is the option slave.name of slave 3.
struct OverrideKey {
  std::string generic;
  std::vector<int> numbers;
};

OverrideKey take_apart(std::string_view key) {
  OverrideKey out;
  while (!key.empty()) {
    const std::size_t dot = std::min(key.find('.'), key.size());
    const std::string_view part = key.substr(0, dot);
    int number = -1;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), number);
    if (error == std::errc{} && end == part.data() + part.size()) {
      out.numbers.push_back(number);
    } else {
      out.generic += (out.generic.empty() ? "" : ".") + std::string(part);
    }
    key.remove_prefix(std::min(dot + 1, key.size()));
  }
  return out;
}

bool takes_words(OptionType type) {
  return type == OptionType::text || type == OptionType::identifier || type == OptionType::name ||
         type == OptionType::choice || type == OptionType::cursor;
}

Value override_value(const Option& option, const std::string& text) {
  const std::optional<Value> parsed = parse_value(text);
  const bool words_only = takes_words(option.type) && option.type != OptionType::cursor;
  if (parsed && (!words_only || scalar<std::string>(*parsed) != nullptr)) return *parsed;
  return scalar_value(Scalar(text));
}

/// Puts the numbers of --set into the setting; what is allowed when they do not fit.
std::optional<std::string> take_numbers(Setting& setting, const std::vector<int>& numbers) {
  const std::string_view key = setting.option->key;
  const bool slave = key.starts_with("slave.");
  const bool value = is_repeated(key.substr(0, key.rfind('.'))) && key.substr(0, key.rfind('.')) != "slave";
  if (numbers.size() != (slave ? 1U : 0U) + (value ? 1U : 0U)) {
    if (slave) return value ? "slave.N.value.M.OPTION" : "slave.N.OPTION";
    return value ? fmt::format("{}.N.OPTION", key.substr(0, key.find('.'))) : std::string(key);
  }
  if (slave) setting.slave = numbers.front();
  if (value) setting.value_index = numbers.back();
  if (slave && (setting.slave < 0 || setting.slave > 31)) return "slave numbers 0..31";
  if (value && (setting.value_index < 0 || setting.value_index > 7)) return "value numbers 0..7";
  return std::nullopt;
}

}  // namespace

std::string Setting::key() const {
  std::string out(option->key);
  if (value_index >= 0) out.insert(out.rfind('.'), "." + std::to_string(value_index));
  if (slave >= 0) out.insert(out.find('.'), "." + std::to_string(slave));
  return out;
}

Settings resolve(const Document& document) {
  return Resolver(document).run();
}

void override_setting(Settings& settings, std::string_view assignment) {
  const std::size_t equals = assignment.find('=');
  const Position where{"--set " + std::string(assignment), 0, 0};
  if (equals == std::string_view::npos) {
    settings.problems.push_back({where, "", "found no '='; allowed: KEY=VALUE"});
    return;
  }
  const std::string key(assignment.substr(0, equals));
  const OverrideKey parts = take_apart(key);
  Setting setting;
  setting.option = find_option(parts.generic);
  setting.where = where;
  setting.overridden = true;
  if (setting.option == nullptr) {
    settings.problems.push_back({where, key, unknown_option_text(parts.generic)});
    return;
  }
  if (parts.generic.ends_with(".number")) {
    settings.problems.push_back({where, key, "numbers stand in the file alone; allowed: any other option"});
    return;
  }
  if (const auto form = take_numbers(setting, parts.numbers)) {
    settings.problems.push_back({where, key, fmt::format("found key {}; allowed: {}", key, *form)});
    return;
  }
  setting.value = override_value(*setting.option, std::string(assignment.substr(equals + 1)));
  const std::string full_key = setting.key();
  std::erase_if(settings.items, [&](const Setting& other) { return other.key() == full_key; });
  settings.items.push_back(std::move(setting));
}

}  // namespace cansyncd
