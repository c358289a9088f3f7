#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <string_view>
#include <type_traits>

#include "cansync/config/draft.h"

/// CANsync's rows of options, and what they are written with.
namespace cansyncd::rows {

std::span<const Row> bus_options();              ///< bit rate, start-up, simulated drives
std::span<const Row> failsafe_options();         ///< failsafe
std::span<const Row> line_options();             ///< process, command channel, names of values
std::span<const Row> reference_limit_options();  ///< what reference values may be
std::span<const Row> slave_options();            ///< slaves

// --- options of their own types

/// A name of a slave or value: no number, and none of the words that options and commands take in its place.
constexpr Option name(std::string_view key, std::string_view initial, std::string_view help) {
  constexpr std::int64_t kLongestName = 64;
  Option option = config::rows::string(key, OptionType::name, initial, 1, kLongestName, help);
  option.choices = "automatic|nobody|all";
  return option;
}

inline constexpr std::string_view kCursorWords =
    "\"automatic\", \"nobody\", or number or name of a configured slave";
inline constexpr std::string_view kSlavesWords = "a list of numbers or names of configured slaves";
inline constexpr std::string_view kRegistersWords = "a list of four numbers 0..127";
inline constexpr std::string_view kValuesWords = "a list of four numbers -1..7";
inline constexpr std::string_view kFlagsWords = "a list of four times true or false";

/// "automatic", "nobody", or a configured slave.
bool takes_cursor(const Draft& draft, const Value& value);
/// A list of configured slaves, by number or name.
bool takes_slaves(const Draft& draft, const Value& value);
bool takes_registers(const Draft& draft, const Value& value);  ///< four register bytes of a mapping
bool takes_value_numbers(const Draft& draft,
                         const Value& value);  ///< four value numbers of a mapping, -1 = unused
/// Four times true or false.
bool takes_flags(const Draft& draft, const Value& value);

// --- what a row takes out of a value that has passed its option

/// The configured slave of that number or name.
std::optional<cansync::SlaveNumber> find_slave(const Config& config, const Scalar& who);

/// What `takes_cursor` has accepted.
cansync::Cursor to_cursor(const Config& config, const Value& value);
/// The same the other way round.
Value to_value(const cansync::Cursor& cursor);

/// A bit for each slave of a list that `takes_slaves` has accepted.
cansync::SlaveMask slave_mask(const Config& config, const Value& value);

/// The items of a list that has four.
template <class T>
std::array<T, cansync::kWords> four(const Value& value) {
  using Source = std::conditional_t<std::is_same_v<T, bool>, bool, std::int64_t>;
  std::array<T, cansync::kWords> out = {};
  std::transform(value.items.begin(), value.items.end(), out.begin(),
                 [](const Scalar& item) { return static_cast<T>(std::get<Source>(item)); });
  return out;
}

// --- where a row puts it

/// Of the slave that the section is of.
inline cansync::SlaveSettings& slave_settings(Draft& draft) {
  return draft.config.master.slaves[draft.slave];
}
/// The actual value that the section is of.
inline ValueConfig& actual_value(Draft& draft) {
  return draft.config.slaves[draft.slave].actual[draft.value];
}
/// The reference value that the section is of.
inline ValueConfig& reference_value(Draft& draft) {
  return draft.config.references[draft.value];
}
/// Changes one actual value of every slave.
template <class Change>
void for_all(Draft& draft, Change&& change) {
  for (SlaveConfig& slave : draft.config.slaves) change(slave.actual[draft.value]);
}
/// Of the command channel.
inline cansync::CommandChannelSettings& channel(Draft& draft) {
  return draft.config.master.command_channel;
}

// --- texts that several rows share

inline constexpr std::string_view kRegistersHelp =
    "Mapping of the first telegram as four register bytes, word 0 first: bit 0 assigned, bit 1 high word, "
    "bits 2..6 value number; 0x0D = low word of value 3. Either this form, or values and high.";
inline constexpr std::string_view kValuesHelp =
    "Mapping of the first telegram as four value numbers, word 0 first; -1 = word unused. Needs the option "
    "high of the same telegram beside it.";
inline constexpr std::string_view kHighHelp =
    "Beside the value numbers: true = that word carries the value's high word.";
inline constexpr std::string_view kSecondHelp = "As above, for the second telegram.";
inline constexpr std::string_view kFactorHelp =
    "scaled = number * factor + offset; the number is the raw value, read with its width and sign (see "
    "signed).";
inline constexpr std::string_view kSignedHelp =
    "The number is two's complement, of 16 bits when the mapping in force carries the value's low word "
    "alone, else of 32; false: it has no sign.";

}  // namespace cansyncd::rows
