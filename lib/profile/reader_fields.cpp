#include "profile/reader_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>
#include <variant>

#include "text/visible.h"

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

/// The decimal digits as a number up to `highest`.
std::optional<std::int64_t> whole_number(std::string_view digits, std::int64_t highest) {
  std::int64_t number = -1;
  const auto end = std::from_chars(digits.data(), digits.data() + digits.size(), number).ptr;
  if (end != digits.data() + digits.size() || number < 0 || number > highest) return std::nullopt;
  return number;
}

}  // namespace

template <class T>
const T* Fields::value(std::string_view key) const {
  const config::Node* node = content_.find(key);
  return node == nullptr || node->kind != config::Node::Kind::value ? nullptr
                                                                    : config::scalar<T>(node->value);
}

void Fields::only(std::initializer_list<std::string_view> keys) {
  std::string allowed;
  for (const std::string_view key : keys) allowed += fmt::format("{}{}", allowed.empty() ? "" : ", ", key);
  for (const config::Node* node : content_.nodes()) {
    if (std::find(keys.begin(), keys.end(), node->name()) != keys.end()) continue;
    problems_.push_back({node->key, fmt::format("{}.{}", prefix_, node->name()),
                         "no key of this section; allowed: " + allowed});
  }
}

void Fields::require(std::string_view key, std::string_view allowed) {
  if (!has(key)) problem(key, fmt::format("is missing; allowed: {}", allowed));
}

std::optional<std::string> Fields::text(std::string_view key, std::size_t most) {
  if (!has(key)) return std::nullopt;
  const auto* text = value<std::string>(key);
  if (text != nullptr && text->size() <= most && std::none_of(text->begin(), text->end(), is_control)) {
    return *text;
  }
  mismatch(key, fmt::format("a string of up to {} bytes on one line", most));
  return std::nullopt;
}

std::optional<std::string> Fields::word(std::string_view key, std::size_t most) {
  if (!has(key)) return std::nullopt;
  const auto* text = value<std::string>(key);
  if (text != nullptr && text->size() <= most &&
      std::none_of(text->begin(), text->end(), [](char c) { return is_control(c) || c == ' '; })) {
    return *text;
  }
  mismatch(key, fmt::format("a string of up to {} bytes without blanks", most));
  return std::nullopt;
}

std::optional<std::string> Fields::name(std::string_view key) {
  if (!has(key)) return std::nullopt;
  const auto* text = value<std::string>(key);
  if (text != nullptr && is_name(*text)) return *text;
  mismatch(key, "1..64 lower-case letters, digits and '-', beginning with a letter, in quotes");
  return std::nullopt;
}

std::vector<Meaning> Fields::meanings(std::string_view key, std::int64_t highest) {
  constexpr std::size_t kLongest = 60;
  if (!has(key)) return {};
  const config::Node* node = content_.find(key);
  std::vector<Meaning> found;
  bool good = node->kind == config::Node::Kind::value && node->value.kind == config::Value::Kind::list;
  for (std::size_t i = 0; good && i < node->value.items.size(); ++i) {
    const auto* text = std::get_if<std::string>(&node->value.items[i]);
    std::int64_t number = -1;
    const auto blank = text == nullptr ? std::string::npos : text->find(' ');
    good = blank != std::string::npos && std::none_of(text->begin(), text->end(), is_control) &&
           std::from_chars(text->data(), text->data() + blank, number).ptr == text->data() + blank &&
           number >= 0 && number <= highest;
    if (!good) break;
    Meaning meaning{static_cast<std::uint32_t>(number), text->substr(blank + 1), text->back() == '!'};
    if (meaning.fault) meaning.words.pop_back();
    good = !meaning.words.empty() && meaning.words.size() <= kLongest &&
           std::none_of(found.begin(), found.end(),
                        [&](const Meaning& m) { return m.number == meaning.number; });
    found.push_back(std::move(meaning));
  }
  if (good) return found;
  mismatch(
      key,
      fmt::format("a list of \"NUMBER WORDS\", each number of 0..{} once, words of 1..{} bytes, with '!' at "
                  "their end for a fault",
                  highest, kLongest));
  return {};
}

std::vector<Recognition> Fields::recognitions(std::string_view key) {
  constexpr std::int64_t kHighestNumber = 4095;
  constexpr std::int64_t kHighestValue = 0xFFFFFFFF;
  if (!has(key)) return {};
  const config::Node* node = content_.find(key);
  std::vector<Recognition> found;
  bool good = node->kind == config::Node::Kind::value && node->value.kind == config::Value::Kind::list &&
              !node->value.items.empty();
  for (std::size_t i = 0; good && i < node->value.items.size(); ++i) {
    const auto* text = std::get_if<std::string>(&node->value.items[i]);
    const auto equals = text == nullptr ? std::string::npos : text->find('=');
    good = equals != std::string::npos;
    if (!good) break;
    const auto number = whole_number(std::string_view(*text).substr(0, equals), kHighestNumber);
    const auto value = whole_number(std::string_view(*text).substr(equals + 1), kHighestValue);
    good = number && value && std::none_of(found.begin(), found.end(), [&](const Recognition& known) {
             return known.number == *number;
           });
    if (good) found.push_back({static_cast<std::uint16_t>(*number), static_cast<std::uint32_t>(*value)});
  }
  if (good) return found;
  mismatch(key,
           "a list of \"NUMBER=VALUE\", at least one, parameter numbers 0..4095 each once, raw values "
           "0..4294967295");
  return {};
}

std::optional<std::size_t> Fields::choice(std::string_view key,
                                          std::initializer_list<std::string_view> choices) {
  if (!has(key)) return std::nullopt;
  std::string allowed;
  for (const std::string_view choice : choices) {
    allowed += fmt::format("{}\"{}\"", allowed.empty() ? "" : ", ", choice);
  }
  if (const auto* text = value<std::string>(key)) {
    const auto* place = std::find(choices.begin(), choices.end(), *text);
    if (place != choices.end()) return static_cast<std::size_t>(place - choices.begin());
  }
  mismatch(key, allowed);
  return std::nullopt;
}

std::optional<std::int64_t> Fields::integer(std::string_view key, std::int64_t minimum,
                                            std::int64_t maximum) {
  if (!has(key)) return std::nullopt;
  const auto* number = value<std::int64_t>(key);
  if (number != nullptr && *number >= minimum && *number <= maximum) return *number;
  mismatch(key, fmt::format("{}..{}", minimum, maximum));
  return std::nullopt;
}

std::optional<double> Fields::number(std::string_view key) {
  if (!has(key)) return std::nullopt;
  if (const auto* whole = value<std::int64_t>(key)) return static_cast<double>(*whole);
  const auto* number = value<double>(key);
  if (number != nullptr && std::isfinite(*number)) return *number;
  mismatch(key, "a finite number");
  return std::nullopt;
}

std::optional<bool> Fields::flag(std::string_view key) {
  if (!has(key)) return std::nullopt;
  if (const auto* flag = value<bool>(key)) return *flag;
  mismatch(key, "true or false");
  return std::nullopt;
}

void Fields::problem(std::string_view key, std::string text) {
  const config::Node* node = content_.find(key);
  problems_.push_back({node != nullptr ? node->where : content_.where(), fmt::format("{}.{}", prefix_, key),
                       std::move(text)});
}

std::string Fields::found(std::string_view key) const {
  constexpr std::size_t kShown = 80;
  const config::Node* node = content_.find(key);
  if (node == nullptr) return "nothing";
  if (node->kind != config::Node::Kind::value) return "a section";
  if (node->value.kind == config::Value::Kind::list) return "a value of type array";
  const auto* quoted = config::scalar<std::string>(node->value);
  std::string text = quoted != nullptr ? *quoted : node->value.text;
  text = text::visible(text.substr(0, kShown)) + (text.size() > kShown ? "..." : "");
  return quoted != nullptr ? "\"" + text + "\"" : text;
}

void Fields::mismatch(std::string_view key, std::string_view allowed) {
  problem(key, fmt::format("found {}; allowed: {}", found(key), allowed));
}

}  // namespace detail
}  // namespace profile
