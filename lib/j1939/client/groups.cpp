#include "j1939/client/groups.h"

#include <algorithm>
#include <limits>
#include <string_view>
#include <utility>

#include "j1939/identifier.h"

namespace j1939::client {
namespace {

/// How well an address of the file fits that of a message: 2 the same, 1 it stands for any, 0 another.
unsigned fit_of(Address in_file, Address of_message) noexcept {
  if (in_file == of_message) return 2;
  return in_file >= kNullAddress ? 1 : 0;
}

}  // namespace

Groups::Groups(dbc::Database database) : database_(std::move(database)) {
  const std::vector<dbc::Message>& messages = database_.messages();
  for (std::size_t i = 0; i < messages.size(); ++i) {
    if (!messages[i].extended) continue;
    const Identifier parts = parse(messages[i].identifier);
    groups_.push_back({pgn_of(parts), parts.source, destination_of(parts), i});
  }
  std::stable_sort(groups_.begin(), groups_.end(),
                   [](const Group& one, const Group& other) { return one.pgn < other.pgn; });
}

Groups::Found Groups::find(Pgn pgn, Address source, Address destination) const noexcept {
  const auto first = std::lower_bound(groups_.begin(), groups_.end(), pgn,
                                      [](const Group& one, Pgn wanted) { return one.pgn < wanted; });
  const auto last = std::find_if(first, groups_.end(), [pgn](const Group& one) { return one.pgn != pgn; });
  if (first == last) return {};
  const auto fit = [&](const Group& one) {
    return std::pair(fit_of(one.destination, destination), fit_of(one.source, source));
  };
  const auto found = std::max_element(
      first, last, [&](const Group& one, const Group& other) { return fit(one) < fit(other); });
  const bool for_another = fit(*found).first == 0;
  const auto others = std::count_if(first, last, [&](const Group& one) {
    return &one != &*found &&
           (fit(one) == fit(*found) || (for_another && one.destination != found->destination));
  });
  return {&database_.messages()[found->message], static_cast<std::size_t>(others)};
}

// Whole bytes, up to four, say it by the highest one. Fields of three, five and more bits have all their values, but the seven bits of an
// occurrence count (SAE J1939-73).
std::string_view state_of(const dbc::Signal& signal, std::uint64_t raw) {
  constexpr unsigned kLongestMeasured = 32;
  constexpr std::uint64_t kSpecific = 0xFB;
  constexpr std::uint64_t kError = 0xFE;
  constexpr std::uint64_t kNotAvailable = 0xFF;
  if (signal.kind != dbc::NumberKind::unsigned_integer) return {};
  if (signal.length % 8 == 0 && signal.length <= kLongestMeasured) {
    const std::uint64_t highest = raw >> (signal.length - 8);
    if (highest == kNotAvailable) return "not available";
    if (highest == kError) return "error";
    if (highest == kSpecific) return "parameter specific";
    return highest > kSpecific ? "reserved" : std::string_view();
  }
  switch (signal.length) {
    case 2:
      return raw == 3 ? "not available" : raw == 2 ? "error" : std::string_view();
    case 4:
      return raw == 0xF ? "not available" : std::string_view();
    case 7:
      return raw == 0x7F ? "not available" : std::string_view();
    default:
      return {};
  }
}

dbc::Signal with_states(dbc::Signal signal) {
  if (signal.chooses || signal.length > 32) return signal;
  const std::uint64_t all = (std::uint64_t{1} << signal.length) - 1;
  const std::uint64_t step = signal.length % 8 == 0 ? std::uint64_t{1} << (signal.length - 8) : 1;
  for (const std::uint64_t raw : {all, all - step}) {
    const std::string_view state = state_of(signal, raw);
    const auto has_it = [&](const auto& word) { return word.second == state; };
    if (!state.empty() && std::none_of(signal.words.begin(), signal.words.end(), has_it))
      signal.words.emplace_back(static_cast<std::int64_t>(raw), state);
  }
  return signal;
}

std::vector<dbc::Reading> read_group(const dbc::Message& message, std::span<const std::uint8_t> data) {
  std::vector<dbc::Reading> readings = dbc::read_signals(message, data);
  for (dbc::Reading& reading : readings) {
    if (!reading.word.empty()) continue;
    reading.word = state_of(*reading.signal, reading.raw);
    if (!reading.word.empty()) reading.value = std::numeric_limits<double>::quiet_NaN();
  }
  return readings;
}

}  // namespace j1939::client
