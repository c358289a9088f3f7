#include <cansync/signals.h>
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <string_view>
#include <utility>
#include <variant>

#include "dbc/by_name.h"
#include "dbc/database.h"
#include "dbc/encode.h"
#include "j1939/client/groups.h"
#include "j1939/identifier.h"
#include "signals/signal_file.h"
#include "text/counts.h"

namespace cansync::client {

struct Signals::Names {
  j1939::client::Groups groups;
  std::vector<std::string> remarks;
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

signals::SignalFile file_of(const std::string& path) {
  const std::string text = content_of(path);
  auto read = signals::read_signal_file(text, path);
  if (auto* file = std::get_if<signals::SignalFile>(&read)) return std::move(*file);
  throw SignalError(std::get<std::string>(read));
}

NamedMessage named(const dbc::Message& message, const std::vector<dbc::Reading>& readings) {
  NamedMessage out{.name = message.name};
  for (const dbc::Reading& reading : readings)
    out.signals.push_back({.name = reading.signal->name,
                           .value = reading.value,
                           .unit = reading.signal->unit,
                           .raw = reading.raw,
                           .word = reading.text.empty() ? std::string(reading.word) : reading.text});
  return out;
}

/// What was found. Throws SignalError, which names `place`.
template <class T>
T found(std::variant<T, std::string> what, std::string_view place) {
  if (const auto* problem = std::get_if<std::string>(&what))
    throw SignalError(fmt::format("{}: {}", place, *problem));
  return std::get<T>(what);
}

std::uint64_t bits_in(const dbc::Signal& signal, const Signals::Setting& setting) {
  return found(std::visit([&signal](const auto& value) { return dbc::bits_of(signal, value); }, setting),
               fmt::format("signal '{}'", signal.name));
}

}  // namespace

Signals::Signals(std::shared_ptr<const Names> names) noexcept : names_(std::move(names)) {}

Signals Signals::read(const std::string& path) {
  signals::SignalFile file = file_of(path);
  if (file.more_remarks > 0)
    file.remarks.push_back(path + ": and " + text::counted(file.more_remarks, "more remark"));
  return Signals(std::make_shared<const Names>(
      Names{j1939::client::Groups(std::move(file.database)), std::move(file.remarks)}));
}

const std::vector<std::string>& Signals::remarks() const noexcept {
  return names_->remarks;
}

std::optional<NamedMessage> Signals::decode(std::uint32_t identifier, bool extended,
                                            std::span<const std::uint8_t> data) const {
  const dbc::Message* message = names_->groups.database().find(identifier, extended);
  if (message == nullptr) return std::nullopt;
  return named(*message, dbc::read_signals(*message, data));
}

std::optional<NamedMessage> Signals::decode_group(std::uint32_t pgn, std::uint8_t source,
                                                  std::uint8_t destination,
                                                  std::span<const std::uint8_t> data) const {
  const dbc::Message* message = names_->groups.find(pgn, source, destination).message;
  if (message == nullptr) return std::nullopt;
  return named(*message, j1939::client::read_group(*message, data));
}

std::optional<NamedMessage> Signals::decode_group(std::uint32_t pgn, std::uint8_t source,
                                                  std::span<const std::uint8_t> data) const {
  return decode_group(pgn, source, j1939::kGlobalAddress, data);
}

EncodedMessage Signals::encode(const std::string& message, const std::map<std::string, Setting>& signals,
                               std::uint8_t rest) const {
  const dbc::Message& wanted = *found(dbc::message_by_name(names_->groups.database(), message), "message");
  EncodedMessage out{.identifier = wanted.identifier, .extended = wanted.extended};
  out.data.assign(wanted.length, rest);
  for (const auto& [name, setting] : signals) {
    const dbc::Signal& signal = *found(dbc::signal_by_name(wanted, name), "signal");
    (void)dbc::write_bits(signal, bits_in(signal, setting), out.data);
    dbc::choose(wanted, signal, out.data);
  }
  // What a signal chose must still be so: two that are never there together would hide each other.
  const auto readings = dbc::read_signals(wanted, out.data);
  for (const auto& wish : signals) {
    const bool there = std::any_of(readings.begin(), readings.end(), [&](const dbc::Reading& one) {
      return one.signal->name == wish.first && one.raw == bits_in(*one.signal, wish.second);
    });
    if (!there)
      throw SignalError(fmt::format("signal '{}': it cannot be in one message with the others", wish.first));
  }
  return out;
}

}  // namespace cansync::client
