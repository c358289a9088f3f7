#pragma once

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "config/document.h"
#include "config/rows.h"
#include "config/settings.h"

/// A table of options that has nothing to do with this project: ovens and their trays.
namespace bakery {

struct Shop {
  std::string town;
  std::int64_t loaves = -1;
  bool open = false;
};

/// What rows of two owners fill.
struct Draft {
  Shop shop;
  std::vector<std::string> trays;
};

inline bool takes_even(const Shop& /*shop*/, const config::Value& value) {
  const auto* number = config::scalar<std::int64_t>(value);
  return number != nullptr && *number % 2 == 0;
}

inline const config::Rows<Draft>& rows() {
  using namespace config::rows;
  using config::OptionType;
  using config::Row;
  using config::Value;
  static constexpr auto kSections = std::to_array<config::Section>({
      {"shop", "", "The shop."},
      {"oven", "oven numbers", "Once for each oven."},
      {"oven.tray", "tray numbers", ""},
  });
  static constexpr auto kOvens = std::to_array<Row<Draft>>({
      {whole_number("oven.number", "(required)", 1, 4, "", "Which oven."), [](Draft&, const Value&) {}},
      {reloadable(choice("oven.heat", "\"gas\"", "gas|wood", "What heats it.")), [](Draft&, const Value&) {}},
      {label("oven.tray.number", 9, "Which tray."), [](Draft&, const Value&) {}},
      {reloadable(
           example("\"rye\"", string("oven.tray.bread", OptionType::name, "(none)", 1, 5, "What is on it."))),
       [](Draft& d, const Value& v) { d.trays.push_back(words(v)); }},
  });
  static constexpr auto kShop = std::to_array<Row<Shop>>({
      {string("shop.town", OptionType::identifier, "\"Ulm\"", 1, 8, "Where it is. And where not."),
       [](Shop& s, const Value& v) { s.town = words(v); }},
      {whole_number("shop.loaves", "12", 0, 99, "loaves", "Loaves a day."),
       [](Shop& s, const Value& v) { s.loaves = whole<std::int64_t>(v); }},
      {reloadable(boolean("shop.open", "true", "Is it open?")),
       [](Shop& s, const Value& v) { s.open = flag(v); }},
      {example("4", other("shop.doors", "an even number", "(as the law says)", "Doors.")),
       [](Shop&, const Value&) {}, takes_even},
  });
  static const config::Rows<Draft> all(
      kSections, {std::span<const Row<Draft>>(kOvens), {std::span<const Row<Shop>>(kShop), &Draft::shop}});
  return all;
}

/// What this text gives, with the assignments of --set.
inline config::Settings read(const std::string& toml, const std::vector<std::string>& overrides = {}) {
  config::Settings settings = config::resolve(config::parse_document(toml, "f"), rows().table());
  for (const std::string& assignment : overrides) {
    config::override_setting(settings, assignment, rows().table());
  }
  return settings;
}

}  // namespace bakery
