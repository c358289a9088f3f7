#include "dbc/by_name.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>
#include <vector>

#include "dbc/encode.h"
#include "text/counts.h"

namespace dbc {
namespace {

/// Most names that an error lists.
constexpr std::size_t kNamesListed = 20;

template <class Named>
std::string names_of(const std::vector<Named>& all) {
  std::string names;
  for (std::size_t i = 0; i < all.size() && i < kNamesListed; ++i)
    names += (i == 0 ? "" : ", ") + all[i].name;
  return names + (all.size() > kNamesListed ? " and others" : "");
}

template <class Named>
std::variant<const Named*, std::string> by_name(const std::vector<Named>& all, std::string_view name,
                                                std::string_view kind) {
  const auto is_named = [name](const Named& one) { return one.name == name; };
  const auto count = std::count_if(all.begin(), all.end(), is_named);
  if (count == 1) return &*std::find_if(all.begin(), all.end(), is_named);
  if (count > 1)
    return fmt::format("found '{}', which is the name of {}; allowed: a name that is there once", name,
                       text::counted(static_cast<std::uint64_t>(count), kind));
  return fmt::format("found '{}'; allowed: {}", name, names_of(all));
}

/// What its bits can be and the file allows.
std::pair<double, double> allowed_range(const Signal& signal) {
  const auto [lowest, highest] = range_of(signal);
  if (!signal.limits) return {lowest, highest};
  return {std::max(lowest, signal.limits->first), std::min(highest, signal.limits->second)};
}

/// A value that is rounded to the limit is within it.
bool keeps_limits(const Signal& signal, double value) {
  if (!signal.limits) return true;
  const double rounding = std::abs(signal.factor) / 1000;
  return value >= signal.limits->first - rounding && value <= signal.limits->second + rounding;
}

bool keeps_limits(const Signal& signal, std::string_view digits) {
  double value = 0;
  std::from_chars(digits.data(), digits.data() + digits.size(), value);
  return keeps_limits(signal, value);
}

std::string allowed_text(const Signal& signal) {
  const auto [lowest, highest] = allowed_range(signal);
  std::string words;
  for (const auto& [raw, word] : signal.words) words += fmt::format(", '{}'", word);
  return fmt::format("allowed: {:.10g}..{:.10g}{}{}{}", lowest, highest, signal.unit.empty() ? "" : " ",
                     signal.unit, words);
}

/// What `is_refused`, a value that its bits could be, is told beyond what is allowed.
std::string_view why(bool is_refused) {
  return is_refused ? "; these are the limits in the file: where they are wrong, correct them there" : "";
}

std::string text_refused(const Signal& signal) {
  return fmt::format("it is a text of {}; allowed: signals that are numbers",
                     text::counted(signal.length, "bit"));
}

}  // namespace

std::variant<const Message*, std::string> message_by_name(const Database& database, std::string_view name) {
  return by_name(database.messages(), name, "message");
}

std::variant<const Signal*, std::string> signal_by_name(const Message& message, std::string_view name) {
  return by_name(message.signals, name, "signal");
}

std::variant<std::uint64_t, std::string> bits_of(const Signal& signal, std::string_view value) {
  if (signal.kind == NumberKind::text) return text_refused(signal);
  const auto digits = raw_of_digits(signal, value);
  const bool is_number = digits.has_value() && keeps_limits(signal, value);
  const std::uint64_t number = digits.value_or(0);
  std::vector<std::int64_t> named;
  for (const auto& [raw, word] : signal.words)
    if (word == value) named.push_back(raw);
  if (named.size() > 1)
    return fmt::format("found '{}', which is the name of the raw values {} and {}; allowed: a number", value,
                       named[0], named[1]);
  const auto word = raw_of(signal, value);
  if (is_number && word && number != *word)
    return fmt::format(
        "found '{0}', which is a number and the name of raw value {1}; allowed: another form of the number, such as {0}e0",
        value, named[0]);
  if (is_number) return number;
  if (word) return *word;
  return fmt::format("found '{}'; {}{}", value, allowed_text(signal), why(digits.has_value()));
}

std::variant<std::uint64_t, std::string> bits_of(const Signal& signal, double value) {
  if (signal.kind == NumberKind::text) return text_refused(signal);
  const auto raw = raw_of(signal, value);
  if (raw && keeps_limits(signal, value)) return *raw;
  return fmt::format("found {:.10g}; {}{}", value, allowed_text(signal), why(raw.has_value()));
}

}  // namespace dbc
