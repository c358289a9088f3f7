#include "config/settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "config/shown.h"

namespace config {
namespace {

using Path = std::vector<Node::Step>;

/// "outer.inner.name"
std::string generic_key(const Path& path) {
  std::string out;
  for (const Node::Step& step : path) out += (out.empty() ? "" : ".") + step.name;
  return out;
}

/// "outer[0].inner[1].": tells one section from its neighbours.
std::string section_id(const Path& path, std::size_t steps) {
  std::string out;
  for (std::size_t i = 0; i < steps; ++i) out += fmt::format("{}[{}].", path[i].name, path[i].index);
  return out;
}

std::string sections_text(const Table& table) {
  std::string out;
  for (const Section& section : table.sections()) out += (out.empty() ? "" : ", ") + title(section);
  return out;
}

std::string unknown_option_text(const Table& table, std::string_view key) {
  const std::size_t dot = key.rfind('.');
  const std::string_view section = dot == std::string_view::npos ? "" : key.substr(0, dot);
  if (table.find_section(section) == nullptr) {
    return "no such option; allowed sections: " + sections_text(table);
  }
  std::string out;
  for (const Option& option : table.options()) {
    if (option.section() == section) out += fmt::format("{}{}", out.empty() ? "" : ", ", option.name());
  }
  return "no such option; allowed in this section: " + out;
}

std::string section_form(const Section& section) {
  return (section.numbers.empty() ? "one section " : "sections ") + title(section);
}

std::optional<int> small_number(const Value& value, const Option& option) {
  const auto* number = scalar<std::int64_t>(value);
  if (number == nullptr || *number < option.minimum || *number > option.maximum) return std::nullopt;
  return static_cast<int>(*number);
}

/// A key without numbers, with the numbers of its sections: {"outer.inner.name", {3, 0}} ->
/// "outer.3.inner.0.name".
std::string numbered_key(const Table& table, std::string_view key, const std::vector<int>& numbers) {
  std::string out;
  auto number = numbers.begin();
  for (std::size_t dot = key.find('.'); dot != std::string_view::npos; dot = key.find('.', dot + 1)) {
    const std::string_view section = key.substr(0, dot);
    out += section.substr(section.rfind('.') + 1);  // the whole of it without a dot
    out += '.';
    if (table.is_numbered(section) && number != numbers.end()) out += std::to_string(*number++) + '.';
  }
  return out.append(key.substr(key.rfind('.') + 1));
}

/// Walks through a document once and collects settings and problems.
class Resolver {
 public:
  Resolver(const Document& document, const Table& table) : document_(document), table_(table) {}

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

  /// Which number each numbered section has.
  void find_numbers() {
    for (const Node& node : document_.nodes) {
      if (node.kind != Node::Kind::value || node.path.size() < 2 || node.path.back().name != "number")
        continue;
      const std::string section = section_id(node.path, node.path.size() - 1);
      const Option* option = table_.find(generic_key(node.path));
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
    if (const Option* option = table_.find(key)) {
      problem(node.key, key, fmt::format("found a section; allowed: {}", allowed(*option)));
      skip(node);
    } else if (table_.find_section(key) == nullptr) {
      problem(node.key, key, "no such section; allowed: " + sections_text(table_));
      skip(node);
    } else if (many != table_.is_numbered(key)) {
      problem(node.key, key,
              fmt::format("found {} brackets; allowed: {}", many ? "double" : "single",
                          section_form(*table_.find_section(key))));
      skip(node);
    } else if (node.kind == Node::Kind::section && many) {
      numbered_section(node, key);
    }
  }

  void numbered_section(const Node& node, const std::string& key) {
    const std::string id = section_id(node.path, node.path.size());
    const Option& option = *table_.find(key + ".number");
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
              fmt::format("found {}; allowed: {}", shown(value->value.text), allowed(option)));
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
    const Option* option = table_.find(key);
    if (option == nullptr) {
      const Section* section = table_.find_section(key);
      problem(node.key, key,
              section != nullptr
                  ? fmt::format("found {}; allowed: {}", shown(node.value.text), section_form(*section))
                  : unknown_option_text(table_, key));
      return;
    }
    Setting setting;
    setting.option = option;
    setting.value = node.value;
    setting.where = node.where;
    for (std::size_t steps = 1; steps < node.path.size(); ++steps) {
      const auto number = numbers_.find(section_id(node.path, steps));
      if (number != numbers_.end()) setting.numbers.push_back(*number->second.first);
    }
    setting.key = numbered_key(table_, option->key, setting.numbers);
    settings_.items.push_back(std::move(setting));
  }

  const Document& document_;
  const Table& table_;
  Settings settings_;
  std::map<std::string, std::pair<std::optional<int>, Position>> numbers_;
  std::map<std::string, std::uint32_t> used_;
  std::set<std::string> skip_;
};

/// A key of --set taken apart: "outer.3.name" is the option outer.name of number 3.
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

/// A string may go without quotes, and a word that is no TOML is one.
Value override_value(const Option& option, const std::string& text) {
  const bool words_only = option.type == OptionType::text || option.type == OptionType::identifier ||
                          option.type == OptionType::name || option.type == OptionType::choice;
  const std::optional<Value> parsed = parse_value(text);
  if (parsed && (!words_only || scalar<std::string>(*parsed) != nullptr)) return *parsed;
  return scalar_value(Scalar(text));
}

/// What is allowed when the numbers in a key of --set do not fit.
std::optional<std::string> wrong_numbers(const Table& table, const Setting& setting) {
  constexpr std::string_view kLetters = "NMKL";
  std::string form;
  std::size_t count = 0;
  std::optional<std::string> range;
  const std::string_view key = setting.option->key;
  for (std::size_t begin = 0, dot = key.find('.'); dot != std::string_view::npos;
       begin = dot + 1, dot = key.find('.', begin)) {
    form += fmt::format("{}.", key.substr(begin, dot - begin));
    const Section* section = table.find_section(key.substr(0, dot));
    if (section == nullptr || section->numbers.empty()) continue;
    const Option& option = *table.find(fmt::format("{}.number", section->name));
    if (!range && count < setting.numbers.size() &&
        (setting.numbers[count] < option.minimum || setting.numbers[count] > option.maximum)) {
      range = fmt::format("{} {}..{}", section->numbers, option.minimum, option.maximum);
    }
    form += fmt::format("{}.", kLetters[std::min(count, kLetters.size() - 1)]);
    ++count;
  }
  if (setting.numbers.size() == count) return range;
  return count == 0 ? std::string(key) : form + "OPTION";
}

}  // namespace

Settings resolve(const Document& document, const Table& table) {
  return Resolver(document, table).run();
}

void override_setting(Settings& settings, std::string_view assignment, const Table& table) {
  const std::size_t equals = assignment.find('=');
  const Position where{"--set " + std::string(assignment), 0, 0};
  if (equals == std::string_view::npos) {
    settings.problems.push_back({where, "", "found no '='; allowed: KEY=VALUE"});
    return;
  }
  const std::string key(assignment.substr(0, equals));
  OverrideKey parts = take_apart(key);
  Setting setting;
  setting.option = table.find(parts.generic);
  setting.numbers = std::move(parts.numbers);
  setting.where = where;
  setting.overridden = true;
  if (setting.option == nullptr) {
    settings.problems.push_back({where, key, unknown_option_text(table, parts.generic)});
    return;
  }
  if (setting.option->numbers_section()) {
    settings.problems.push_back({where, key, "numbers stand in the file alone; allowed: any other option"});
    return;
  }
  if (const auto form = wrong_numbers(table, setting)) {
    settings.problems.push_back({where, key, fmt::format("found key {}; allowed: {}", key, *form)});
    return;
  }
  setting.key = numbered_key(table, setting.option->key, setting.numbers);
  setting.value = override_value(*setting.option, std::string(assignment.substr(equals + 1)));
  std::erase_if(settings.items, [&](const Setting& other) { return other.key == setting.key; });
  settings.items.push_back(std::move(setting));
}

Settings read_settings(const Source& source, std::span<const std::string> overrides, const Table& table) {
  Settings settings = resolve(read_document(source), table);
  for (const std::string& assignment : overrides) override_setting(settings, assignment, table);
  return settings;
}

}  // namespace config
