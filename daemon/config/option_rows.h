#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "cansync/timing.h"
#include "daemon/config/options.h"

/// What the rows of the option table are written with; only for config_options*.cpp.
namespace cansyncd::rows {

using cansync::EnableRule;
using cansync::Serving;
using cansync::SlaveNumber;
using Apply = void (*)(Draft&, const Value&);

// --- rows. A default in round brackets is what holds when the option is not given, in words.

constexpr Option plain(std::string_view key, OptionType type, std::string_view initial, std::string_view help,
                       Apply apply) {
  Option option;
  option.key = key;
  option.type = type;
  option.initial = initial;
  option.help = help;
  option.apply = apply;
  return option;
}

constexpr Option whole_number(std::string_view key, std::string_view initial, std::int64_t minimum,
                              std::int64_t maximum, std::string_view unit, std::string_view help,
                              Apply apply) {
  Option option = plain(key, OptionType::integer, initial, help, apply);
  option.minimum = minimum;
  option.maximum = maximum;
  option.unit = unit;
  return option;
}

/// One of a few whole numbers, separated by '|'.
constexpr Option one_number(std::string_view key, std::string_view initial, std::string_view choices,
                            std::string_view unit, std::string_view help, Apply apply) {
  Option option = plain(key, OptionType::integer, initial, help, apply);
  option.choices = choices;
  option.unit = unit;
  return option;
}

constexpr Option real_number(std::string_view key, std::string_view initial, bool not_zero,
                             std::string_view help, Apply apply) {
  Option option = plain(key, OptionType::number, initial, help, apply);
  option.not_zero = not_zero;
  return option;
}

/// One of a few words, separated by '|'.
constexpr Option choice(std::string_view key, std::string_view initial, std::string_view choices,
                        std::string_view help, Apply apply) {
  Option option = plain(key, OptionType::choice, initial, help, apply);
  option.choices = choices;
  return option;
}

/// A string of minimum..maximum bytes.
constexpr Option string(std::string_view key, OptionType type, std::string_view initial, std::int64_t minimum,
                        std::int64_t maximum, std::string_view help, Apply apply) {
  Option option = plain(key, type, initial, help, apply);
  option.minimum = minimum;
  option.maximum = maximum;
  return option;
}

constexpr Option reloadable(Option option) {
  option.reload = true;
  return option;
}

// --- what a row takes out of a value that `mismatch` has passed

template <class T>
T whole(const Value& value) {
  return static_cast<T>(std::get<std::int64_t>(value.items.front()));
}

inline std::chrono::milliseconds milliseconds(const Value& value) {
  return std::chrono::milliseconds(whole<std::int64_t>(value));
}

inline bool flag(const Value& value) {
  return std::get<bool>(value.items.front());
}

inline const std::string& words(const Value& value) {
  return std::get<std::string>(value.items.front());
}

inline double real(const Value& value) {
  if (const auto* number = scalar<std::int64_t>(value)) return static_cast<double>(*number);
  return std::get<double>(value.items.front());
}

template <class T>
std::array<T, cansync::kWords> four(const Value& value) {
  using Source = std::conditional_t<std::is_same_v<T, bool>, bool, std::int64_t>;
  std::array<T, cansync::kWords> out = {};
  std::transform(value.items.begin(), value.items.end(), out.begin(),
                 [](const Scalar& item) { return static_cast<T>(std::get<Source>(item)); });
  return out;
}

inline cansync::SlaveMask slave_mask(const Config& config, const Value& value) {
  cansync::SlaveMask mask;
  for (const Scalar& item : value.items) {
    if (const auto slave = find_slave(config, item)) mask.set(*slave);
  }
  return mask;
}

// --- where a row puts it

inline cansync::SlaveSettings& slave_settings(Draft& draft) {
  return draft.config.master.slaves[draft.slave];
}
inline ValueConfig& actual_value(Draft& draft) {
  return draft.config.slaves[draft.slave].actual[draft.value];
}
inline ValueConfig& reference_value(Draft& draft) {
  return draft.config.references[draft.value];
}
/// Changes one actual value of every slave.
template <class Change>
void for_all(Draft& draft, Change&& change) {
  for (SlaveConfig& slave : draft.config.slaves) change(slave.actual[draft.value]);
}
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
inline constexpr std::string_view kCommonMappingHelp =
    "Mapping of the first actual value telegram, for slaves that do not give their own; forms as above.";
inline constexpr std::string_view kSecondHelp = "As above, for the second telegram.";
inline constexpr std::string_view kFactorHelp =
    "scaled = number * factor + offset; the number is the raw value, read with its width and sign (see "
    "signed).";
inline constexpr std::string_view kSignedHelp =
    "The number is two's complement, of 16 bits when the mapping in force carries the value's low word "
    "alone, else of 32; false: it has no sign.";
inline constexpr std::string_view kMappingOne = "(doubleword values 0 and 1, low word first)";
inline constexpr std::string_view kMappingTwo = "(doubleword values 4 and 5, low word first)";

// --- the parts of the table

std::span<const Option> daemon_options();    ///< bus, realtime, recorder, startup, dds, sim
std::span<const Option> failsafe_options();  ///< failsafe
std::span<const Option> access_options();    ///< access
std::span<const Option> metrics_options();   ///< metrics
std::span<const Option> sync_options();      ///< sync
std::span<const Option> slave_options();     ///< slaves that come and go: startup, command channel, slaves
std::span<const Option> line_options();      ///< process, command channel, reference values, slaves

}  // namespace cansyncd::rows
