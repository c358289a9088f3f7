#include "cli/j1939/group_signals.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>
#include <system_error>

#include "cli/base/session.h"
#include "dbc/encode.h"
#include "j1939/identifier.h"
#include "text/counts.h"

namespace cansync::cli {
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
const Named& find_named(const std::vector<Named>& all, std::string_view name, std::string_view what) {
  const auto found =
      std::find_if(all.begin(), all.end(), [name](const Named& one) { return one.name == name; });
  if (found == all.end())
    throw UsageError(fmt::format("{}: found '{}'; the file has {}", what, name, names_of(all)));
  return *found;
}

std::uint64_t raw_in(const dbc::Signal& signal, std::string_view text) {
  double value = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool number = read.ec == std::errc() && read.ptr == text.data() + text.size();
  const auto raw = number ? dbc::raw_of(signal, value) : dbc::raw_of(signal, text);
  if (raw) return *raw;
  const auto [lowest, highest] = dbc::range_of(signal);
  std::string words;
  for (const auto& [key, word] : signal.words) words += fmt::format(", '{}'", word);
  throw UsageError(fmt::format("--set {}: found '{}'; allowed: {:.10g}..{:.10g}{}{}{}", signal.name, text,
                               lowest, highest, signal.unit.empty() ? "" : " ", signal.unit, words));
}

/// The multiplexor of a signal that is there with one of its values only.
void choose(const dbc::Message& message, const dbc::Signal& signal, std::vector<std::uint8_t>& data) {
  if (!signal.chosen_by) return;
  for (const dbc::Signal& one : message.signals)
    if (one.chooses) (void)dbc::write_bits(one, *signal.chosen_by, data);
}

}  // namespace

j1939::client::Message encode_group(const dbc::Database& database, const std::string& name,
                                    std::span<const std::string> settings) {
  const dbc::Message& message = find_named(database.messages(), name, "PGN");
  if (!message.extended)
    throw UsageError(fmt::format("PGN: message '{}' has an identifier of 11 bits; allowed: one of 29", name));
  const j1939::Identifier parts = j1939::parse(message.identifier);
  j1939::client::Message out;
  out.pgn = j1939::pgn_of(parts);
  out.priority = parts.priority;
  constexpr std::uint8_t kNotAvailable = 0xFF;
  out.data.assign(message.length, kNotAvailable);
  std::vector<const dbc::Signal*> given;
  for (const std::string& setting : settings) {
    const std::size_t at = setting.find('=');
    if (at == std::string::npos)
      throw UsageError(fmt::format("--set: found '{}'; allowed: NAME=VALUE", setting));
    const dbc::Signal& signal = find_named(message.signals, std::string_view(setting).substr(0, at), "--set");
    if (std::find(given.begin(), given.end(), &signal) != given.end())
      throw UsageError(fmt::format("--set {}: it is given twice", signal.name));
    given.push_back(&signal);
    choose(message, signal, out.data);
    if (!dbc::write_bits(signal, raw_in(signal, std::string_view(setting).substr(at + 1)), out.data))
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
