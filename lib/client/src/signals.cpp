#include <cansync/signals.h>
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <string_view>
#include <utility>

#include "dbc/database.h"
#include "dbc/encode.h"
#include "j1939/client/groups.h"
#include "signals/signal_file.h"

namespace cansync::client {

struct Signals::Names {
  dbc::Database database;
};

namespace {

constexpr std::size_t kLargestFile = std::size_t{16} * 1024 * 1024;

std::string content_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw SignalError(path + ": cannot be read; allowed: a DBC file, or a table of signals (.toml)");
  std::string text(kLargestFile + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (text.size() > kLargestFile) throw SignalError(path + ": too large; allowed: 16 MiB");
  return text;
}

dbc::Database database_of(const std::string& path) {
  const std::string text = content_of(path);
  auto read = signals::read_signal_file(text, path);
  if (auto* database = std::get_if<dbc::Database>(&read)) return std::move(*database);
  throw SignalError(std::get<std::string>(read));
}

NamedMessage named(const dbc::Message& message, const std::vector<dbc::Reading>& readings) {
  NamedMessage out{.name = message.name};
  for (const dbc::Reading& reading : readings)
    out.signals.push_back({.name = reading.signal->name,
                           .value = reading.value,
                           .unit = reading.signal->unit,
                           .raw = reading.raw,
                           .word = std::string(reading.word)});
  return out;
}

template <class Named>
const Named& find_named(const std::vector<Named>& all, std::string_view name, std::string_view what) {
  const auto found = std::find_if(all.begin(), all.end(), [&](const Named& one) { return one.name == name; });
  if (found != all.end()) return *found;
  std::string names;
  for (const Named& one : all) names += (names.empty() ? "" : ", ") + one.name;
  throw SignalError(fmt::format("{} '{}': the file has none; allowed: {}", what, name, names));
}

std::uint64_t raw_in(const dbc::Signal& signal, const Signals::Setting& setting) {
  const auto* number = std::get_if<double>(&setting);
  const auto raw =
      number != nullptr ? dbc::raw_of(signal, *number) : dbc::raw_of(signal, std::get<std::string>(setting));
  if (raw) return *raw;
  const auto [lowest, highest] = dbc::range_of(signal);
  std::string words;
  for (const auto& [key, word] : signal.words) words += fmt::format(", '{}'", word);
  throw SignalError(fmt::format(
      "signal '{}': found {}; allowed: {:.10g}..{:.10g}{}{}{}", signal.name,
      number != nullptr ? fmt::format("{:.10g}", *number) : "'" + std::get<std::string>(setting) + "'",
      lowest, highest, signal.unit.empty() ? "" : " ", signal.unit, words));
}

}  // namespace

Signals::Signals(std::shared_ptr<const Names> names) noexcept : names_(std::move(names)) {}

Signals Signals::read(const std::string& path) {
  return Signals(std::make_shared<const Names>(Names{database_of(path)}));
}

std::optional<NamedMessage> Signals::decode(std::uint32_t identifier, bool extended,
                                            std::span<const std::uint8_t> data) const {
  const dbc::Message* message = names_->database.find(identifier, extended);
  if (message == nullptr) return std::nullopt;
  return named(*message, dbc::read_signals(*message, data));
}

std::optional<NamedMessage> Signals::decode_group(std::uint32_t pgn, std::uint8_t source,
                                                  std::span<const std::uint8_t> data) const {
  const dbc::Message* message = j1939::client::find_group(names_->database, pgn, source);
  if (message == nullptr) return std::nullopt;
  return named(*message, j1939::client::read_group(*message, data));
}

EncodedMessage Signals::encode(const std::string& message, const std::map<std::string, Setting>& signals,
                               std::uint8_t rest) const {
  const dbc::Message& wanted = find_named(names_->database.messages(), message, "message");
  EncodedMessage out{.identifier = wanted.identifier, .extended = wanted.extended};
  out.data.assign(wanted.length, rest);
  for (const auto& [name, setting] : signals) {
    const dbc::Signal& signal = find_named(wanted.signals, name, "signal");
    (void)dbc::write_bits(signal, raw_in(signal, setting), out.data);
    if (!signal.chosen_by) continue;
    for (const dbc::Signal& one : wanted.signals)
      if (one.chooses) (void)dbc::write_bits(one, *signal.chosen_by, out.data);
  }
  // What a signal chose must still be so: two that are never there together would hide each other.
  const auto readings = dbc::read_signals(wanted, out.data);
  for (const auto& wish : signals) {
    const bool there = std::any_of(readings.begin(), readings.end(), [&](const dbc::Reading& one) {
      return one.signal->name == wish.first && one.raw == raw_in(*one.signal, wish.second);
    });
    if (!there)
      throw SignalError(fmt::format("signal '{}': it cannot be in one message with the others", wish.first));
  }
  return out;
}

}  // namespace cansync::client
