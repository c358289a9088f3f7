#include "j1939/client/groups.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "j1939/identifier.h"

namespace j1939::client {
namespace {

/// What a raw value says by SAE J1939-71: of whole bytes the highest one, of fewer bits all of them.
std::string_view state_of(const dbc::Signal& signal, std::uint64_t raw) {
  if (signal.kind != dbc::NumberKind::unsigned_integer || signal.length < 2) return {};
  const bool bytes = signal.length % 8 == 0;
  const std::uint64_t largest = bytes ? 0xFF : (std::uint64_t{1} << std::min(signal.length, 63U)) - 1;
  const std::uint64_t shown = bytes ? raw >> (signal.length - 8) : raw;
  if (shown == largest) return "not available";
  return shown == largest - 1 ? "error" : std::string_view();
}

}  // namespace

Groups::Groups(dbc::Database database) : database_(std::move(database)) {
  const std::vector<dbc::Message>& messages = database_.messages();
  for (std::size_t i = 0; i < messages.size(); ++i) {
    if (!messages[i].extended) continue;
    const Identifier parts = parse(messages[i].identifier);
    groups_.push_back({pgn_of(parts), parts.source, i});
  }
  std::stable_sort(groups_.begin(), groups_.end(),
                   [](const Group& one, const Group& other) { return one.pgn < other.pgn; });
}

const dbc::Message* Groups::find(std::uint32_t pgn, std::uint8_t source) const noexcept {
  const Group* found = nullptr;
  const auto first =
      std::lower_bound(groups_.begin(), groups_.end(), pgn,
                       [](const Group& one, std::uint32_t wanted) { return one.pgn < wanted; });
  for (auto group = first; group != groups_.end() && group->pgn == pgn; ++group) {
    if (group->source == source) return &database_.messages()[group->message];
    if (found == nullptr || group->source == kNullAddress) found = &*group;
  }
  return found == nullptr ? nullptr : &database_.messages()[found->message];
}

std::vector<dbc::Reading> read_group(const dbc::Message& message, std::span<const std::uint8_t> data) {
  std::vector<dbc::Reading> readings = dbc::read_signals(message, data);
  for (dbc::Reading& reading : readings)
    if (reading.word.empty()) reading.word = state_of(*reading.signal, reading.raw);
  return readings;
}

}  // namespace j1939::client
