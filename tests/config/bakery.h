#pragma once

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "config/document.h"
#include "config/fields.h"
#include "config/settings.h"

/// A table of options that has nothing to do with this project: ovens and their trays.
namespace bakery {

enum class Day : std::uint8_t { monday, sunday };

struct Shop {
  std::string town = "Ulm";
  std::int64_t loaves = 12;
  bool open = true;
  std::chrono::microseconds rest{1'500'000};
  Day closed = Day::sunday;
};

inline constexpr auto kDays =
    std::to_array<config::rows::Word<Day>>({{"monday", Day::monday}, {"sunday", Day::sunday}});

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
      field(
          [](auto& s) -> auto& { return s.town; },
          string("shop.town", OptionType::identifier, 1, 8, "Where it is. And where not.")),
      field(
          [](auto& s) -> auto& { return s.loaves; },
          whole_number("shop.loaves", 0, 99, "loaves", "Loaves a day.")),
      field(
          [](auto& s) -> auto& { return s.open; }, reloadable(boolean("shop.open", "Is it open?"))),
      duration<std::chrono::milliseconds>(
          [](auto& s) -> auto& { return s.rest; },
          whole_number("shop.rest_ms", 0, 9999, "ms", "Between two loaves.")),
      chosen<kDays>(
          [](auto& s) -> auto& { return s.closed; }, word("shop.closed", "Day without bread.")),
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
