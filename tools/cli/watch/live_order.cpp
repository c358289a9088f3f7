#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>

#include "cli/watch/live_view.h"

namespace cansync::cli {
namespace {

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return out;
}

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(' ');
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(' ') - first + 1);
}

std::optional<unsigned> number(std::string_view text) {
  unsigned value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// One part of the filter, which may be half typed: "5-" is slave 5.
bool fits(const LiveSlave& slave, std::string_view part) {
  if (const auto exact = number(part)) return slave.number == *exact;
  const std::size_t dash = part.find('-');
  if (const auto from = number(part.substr(0, dash)); from && dash != std::string_view::npos) {
    const std::string_view rest = part.substr(dash + 1);
    if (rest.empty()) return slave.number == *from;
    if (const auto to = number(rest)) return slave.number >= *from && slave.number <= *to;
  }
  return lower(slave.name).find(lower(part)) != std::string::npos;
}

bool passes(const LiveSlave& slave, std::string_view filter) {
  bool any = false;
  while (!filter.empty()) {
    const std::size_t comma = filter.find(',');
    const std::string_view part = trimmed(filter.substr(0, comma));
    filter = comma == std::string_view::npos ? std::string_view() : filter.substr(comma + 1);
    if (part.empty()) continue;
    if (fits(slave, part)) return true;
    any = true;
  }
  return !any;
}

/// Whether `a` stands before `b`; what has no value stands last in either order.
template <class T>
std::optional<bool> before(const std::optional<T>& a, const std::optional<T>& b, bool descending) {
  if (!a || !b) return a.has_value() == b.has_value() ? std::nullopt : std::optional(a.has_value());
  if (*a == *b) return std::nullopt;
  return descending ? *b < *a : *a < *b;
}

std::optional<bool> before(const LiveSlave& a, const LiveSlave& b, const ViewState& state) {
  using Text = std::optional<std::string>;
  switch (state.sort) {
    case SortBy::name:
      return before(Text(a.name), Text(b.name), state.descending);
    case SortBy::state:
      return before(Text(a.state), Text(b.state), state.descending);
    case SortBy::age:
      return before(a.age_ms, b.age_ms, state.descending);
    case SortBy::value:
      return before(a.values[state.value].scaled, b.values[state.value].scaled, state.descending);
    case SortBy::number:
      break;
  }
  return before(std::optional(a.number), std::optional(b.number), state.descending);
}

}  // namespace

std::vector<const LiveSlave*> shown_slaves(const LiveModel& model, const ViewState& state) {
  std::vector<const LiveSlave*> out;
  for (const LiveSlave& slave : model.slaves())
    if (passes(slave, state.filter)) out.push_back(&slave);
  // Equal ones stay in the order of their numbers.
  std::stable_sort(out.begin(), out.end(), [&state](const LiveSlave* a, const LiveSlave* b) {
    return before(*a, *b, state).value_or(false);
  });
  return out;
}

std::vector<unsigned> shown_values(const LiveModel& model) {
  std::vector<unsigned> out;
  // Parameters were asked for one by one: they come into sight first.
  for (unsigned place = 0; place < kLiveValues; ++place) {
    const unsigned i = (place + kSlaveValues) % kLiveValues;
    if (std::any_of(model.slaves().begin(), model.slaves().end(),
                    [i](const LiveSlave& slave) { return slave.values[i].mapped; }))
      out.push_back(i);
  }
  return out;
}

ValueHeading value_heading(const LiveModel& model, unsigned value) {
  std::optional<ValueHeading> heading;
  for (const LiveSlave& slave : model.slaves()) {
    const LiveValue& own = slave.values[value];
    if (!own.mapped) continue;
    if (!heading) heading = ValueHeading{own.name, own.unit, true};
    if (heading->name != own.name || heading->unit != own.unit) return {};
  }
  return heading.value_or(ValueHeading{});
}

std::string sort_text(const LiveModel& model, const ViewState& state) {
  switch (state.sort) {
    case SortBy::name:
      return "name";
    case SortBy::state:
      return "state";
    case SortBy::age:
      return "age";
    case SortBy::value: {
      const ValueHeading heading = value_heading(model, state.value);
      return heading.name.empty() ? fmt::format("value {}", state.value) : heading.name;
    }
    case SortBy::number:
      break;
  }
  return "number";
}

}  // namespace cansync::cli
