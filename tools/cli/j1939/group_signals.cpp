#include "cli/j1939/group_signals.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "cli/base/session.h"
#include "dbc/by_name.h"
#include "dbc/encode.h"
#include "j1939/client/groups.h"
#include "j1939/identifier.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

/// What was found. Throws UsageError, which names `place`.
template <class T>
T found(std::variant<T, std::string> what, std::string_view place) {
  if (const auto* problem = std::get_if<std::string>(&what))
    throw UsageError(fmt::format("{}: {}", place, *problem));
  return std::get<T>(what);
}

/// The bits of a setting. Throws UsageError.
std::uint64_t bits_in(const dbc::Signal& of_file, std::string_view value) {
  const dbc::Signal signal = j1939::client::with_states(of_file);
  const std::uint64_t bits = found(dbc::bits_of(signal, value), "--set " + signal.name);
  const bool by_word = std::any_of(signal.words.begin(), signal.words.end(),
                                   [&](const auto& word) { return word.second == value; });
  const bool in_file = std::any_of(of_file.words.begin(), of_file.words.end(), [&](const auto& word) {
    return static_cast<std::uint64_t>(word.first) == bits;
  });
  if (signal.chooses || by_word || in_file) return bits;
  const std::string_view state = j1939::client::state_of(signal, bits);
  if (state.empty()) return bits;
  throw UsageError(fmt::format(
      "--set {}: found '{}', whose bits 0x{:X} say '{}' (SAE J1939-71); allowed: a value, or what the bits "
      "say in words, 'not available' or 'error'; DATA takes any bytes",
      signal.name, value, bits, state));
}

}  // namespace

j1939::client::Message encode_group(const dbc::Database& database, const std::string& name,
                                    std::span<const std::string> settings) {
  const dbc::Message& message = *found(dbc::message_by_name(database, name), "PGN");
  if (!message.extended)
    throw UsageError(fmt::format("PGN: message '{}' has an identifier of 11 bits; allowed: one of 29", name));
  const j1939::Identifier parts = j1939::parse(message.identifier);
  j1939::client::Message out;
  out.pgn = j1939::pgn_of(parts);
  out.priority = parts.priority;
  const j1939::Address destination = j1939::destination_of(parts);
  if (destination < j1939::kNullAddress) out.destination = destination;
  constexpr std::uint8_t kNotAvailable = 0xFF;
  out.data.assign(message.length, kNotAvailable);
  std::vector<const dbc::Signal*> given;
  for (const std::string& setting : settings) {
    const std::size_t at = setting.find('=');
    if (at == std::string::npos)
      throw UsageError(fmt::format("--set: found '{}'; allowed: NAME=VALUE", setting));
    const dbc::Signal& signal =
        *found(dbc::signal_by_name(message, std::string_view(setting).substr(0, at)), "--set");
    if (std::find(given.begin(), given.end(), &signal) != given.end())
      throw UsageError(fmt::format("--set {}: it is given twice", signal.name));
    given.push_back(&signal);
    dbc::choose(message, signal, out.data);
    const std::uint64_t bits = bits_in(signal, std::string_view(setting).substr(at + 1));
    if (!dbc::write_bits(signal, bits, out.data))
      throw UsageError(fmt::format("--set {}: it ends behind the {} that the file gives '{}'", signal.name,
                                   text::counted(message.length, "byte"), name));
  }
  // What a signal chose must still be so: two that are never there together would hide each other.
  const std::vector<dbc::Reading> readings = dbc::read_signals(message, out.data);
  for (const dbc::Signal* signal : given)
    if (std::none_of(readings.begin(), readings.end(), [&](const auto& one) { return one.signal == signal; }))
      throw UsageError(fmt::format("--set {}: it cannot be in one message with the others", signal->name));
  return out;
}

}  // namespace cansync::cli
