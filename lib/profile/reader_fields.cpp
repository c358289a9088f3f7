#include "profile/reader_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace profile {

bool is_name(std::string_view text) noexcept {
  constexpr std::size_t kLongest = 64;
  if (text.empty() || text.size() > kLongest || text.front() < 'a' || text.front() > 'z') return false;
  return std::all_of(text.begin(), text.end(),
                     [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-'; });
}

namespace detail {
namespace {

bool is_control(char c) noexcept {
  constexpr char kDelete = 0x7F;
  return static_cast<unsigned char>(c) < 0x20 || c == kDelete;
}

}  // namespace

void Fields::only(std::initializer_list<std::string_view> keys) {
  std::string allowed;
  for (const std::string_view key : keys) allowed += fmt::format("{}{}", allowed.empty() ? "" : ", ", key);
  for (const auto& [key, node] : table_) {
    if (std::find(keys.begin(), keys.end(), key.str()) != keys.end()) continue;
    const toml::source_region& place = key.source();
    problems_.push_back({place.begin.line, place.begin.column,
                         std::string(prefix_) + "." + std::string(key.str()),
                         "no key of this section; allowed: " + allowed});
  }
}

void Fields::require(std::string_view key, std::string_view allowed) {
  if (!has(key)) problem(key, fmt::format("is missing; allowed: {}", allowed));
}

std::optional<std::string> Fields::text(std::string_view key, std::size_t most) {
  if (!has(key)) return std::nullopt;
  const auto* text = table_.get_as<std::string>(key);
  if (text != nullptr && text->get().size() <= most &&
      std::none_of(text->get().begin(), text->get().end(), is_control)) {
    return text->get();
  }
  mismatch(key, fmt::format("a string of up to {} bytes on one line", most));
  return std::nullopt;
}

std::optional<std::string> Fields::word(std::string_view key, std::size_t most) {
  if (!has(key)) return std::nullopt;
  const auto* text = table_.get_as<std::string>(key);
  if (text != nullptr && text->get().size() <= most &&
      std::none_of(text->get().begin(), text->get().end(),
                   [](char c) { return is_control(c) || c == ' '; })) {
    return text->get();
  }
  mismatch(key, fmt::format("a string of up to {} bytes without blanks", most));
  return std::nullopt;
}

std::optional<std::string> Fields::name(std::string_view key) {
  if (!has(key)) return std::nullopt;
  const auto* text = table_.get_as<std::string>(key);
  if (text != nullptr && is_name(text->get())) return text->get();
  mismatch(key, "1..64 lower-case letters, digits and '-', beginning with a letter, in quotes");
  return std::nullopt;
}

std::optional<std::size_t> Fields::choice(std::string_view key,
                                          std::initializer_list<std::string_view> choices) {
  if (!has(key)) return std::nullopt;
  std::string allowed;
  for (const std::string_view choice : choices) {
    allowed += fmt::format("{}\"{}\"", allowed.empty() ? "" : ", ", choice);
  }
  if (const auto* text = table_.get_as<std::string>(key)) {
    const auto* place = std::find(choices.begin(), choices.end(), text->get());
    if (place != choices.end()) return static_cast<std::size_t>(place - choices.begin());
  }
  mismatch(key, allowed);
  return std::nullopt;
}

std::optional<std::int64_t> Fields::integer(std::string_view key, std::int64_t minimum,
                                            std::int64_t maximum) {
  if (!has(key)) return std::nullopt;
  const auto* number = table_.get_as<std::int64_t>(key);
  if (number != nullptr && number->get() >= minimum && number->get() <= maximum) return number->get();
  mismatch(key, fmt::format("{}..{}", minimum, maximum));
  return std::nullopt;
}

std::optional<double> Fields::number(std::string_view key) {
  if (!has(key)) return std::nullopt;
  if (const auto* whole = table_.get_as<std::int64_t>(key)) return static_cast<double>(whole->get());
  const auto* number = table_.get_as<double>(key);
  if (number != nullptr && std::isfinite(number->get())) return number->get();
  mismatch(key, "a finite number");
  return std::nullopt;
}

std::optional<bool> Fields::flag(std::string_view key) {
  if (!has(key)) return std::nullopt;
  if (const auto* flag = table_.get_as<bool>(key)) return flag->get();
  mismatch(key, "true or false");
  return std::nullopt;
}

void Fields::problem(std::string_view key, std::string text) {
  const toml::node* node = table_.get(key);
  const toml::source_region& place = node != nullptr ? node->source() : table_.source();
  problems_.push_back(
      {place.begin.line, place.begin.column, std::string(prefix_) + "." + std::string(key), std::move(text)});
}

std::string Fields::found(std::string_view key) const {
  constexpr std::size_t kShown = 80;
  const toml::node* node = table_.get(key);
  if (node == nullptr) return "nothing";
  if (!node->is_value()) {
    std::ostringstream type;
    type << "a value of type " << node->type();
    return type.str();
  }
  std::string text;
  if (const auto* quoted = node->as_string()) {
    text = quoted->get();
    std::replace_if(text.begin(), text.end(), is_control, '?');
  } else {
    std::ostringstream out;
    node->visit([&](const auto& value) {
      if constexpr (toml::is_value<decltype(value)>) out << value;
    });
    text = out.str();
  }
  if (text.size() > kShown) text = text.substr(0, kShown) + "...";
  return node->is_string() ? "\"" + text + "\"" : text;
}

void Fields::mismatch(std::string_view key, std::string_view allowed) {
  problem(key, fmt::format("found {}; allowed: {}", found(key), allowed));
}

}  // namespace detail
}  // namespace profile
