#include "j1939/client/groups.h"

#include <algorithm>
#include <string_view>

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

const dbc::Message* find_group(const dbc::Database& database, std::uint32_t pgn, std::uint8_t source) {
  const dbc::Message* found = nullptr;
  for (const dbc::Message& message : database.messages()) {
    if (!message.extended) continue;
    const Identifier parts = parse(message.identifier);
    if (pgn_of(parts) != pgn) continue;
    if (parts.source == source) return &message;
    if (found == nullptr || parts.source == kNullAddress) found = &message;
  }
  return found;
}

std::vector<dbc::Reading> read_group(const dbc::Message& message, std::span<const std::uint8_t> data) {
  std::vector<dbc::Reading> readings = dbc::read_signals(message, data);
  for (dbc::Reading& reading : readings)
    if (reading.word.empty()) reading.word = state_of(*reading.signal, reading.raw);
  return readings;
}

}  // namespace j1939::client
