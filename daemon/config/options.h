#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "daemon/config/config.h"
#include "daemon/config/value.h"

/// The one table of all options: parser, --set, reload, docs/configuration.md and config/cansync.toml all
/// derive from it. Main thread only.
namespace cansyncd {

/// What an option takes.
enum class OptionType : std::uint8_t {
  text,              ///< any string
  identifier,        ///< letters, digits, `_`, `.`, `-`
  name,              ///< a string without control characters that is no number and no reserved word
  integer,           ///< minimum..maximum, or one of `choices`
  number,            ///< a finite number
  boolean,           ///< true or false
  choice,            ///< a string, one of `choices`
  cursor,            ///< "automatic", "nobody", or a slave's number or name
  slaves,            ///< list of slave numbers or names
  registers,         ///< four register bytes of a mapping
  value_numbers,     ///< four value numbers of a mapping, -1 = unused
  flags,             ///< four true or false
  parameter_values,  ///< list of "NUMBER=VALUE"
};

/// One telegram's mapping while a file is being read.
struct MappingDraft {
  std::optional<std::array<std::uint8_t, cansync::kWords>> registers;
  std::optional<std::array<int, cansync::kWords>> values;
  std::optional<std::array<bool, cansync::kWords>> high;
};
using MappingDrafts = std::array<MappingDraft, cansync::kChannels>;

/// A configuration while it is being read.
struct Draft {
  Config config;
  MappingDrafts reference = {};
  MappingDrafts actual_common = {};  ///< of slaves that do not give their own
  std::array<MappingDrafts, cansync::kSlaves> actual = {};
  unsigned slave = 0;  ///< slave number an option of [[slave]] belongs to
  unsigned value = 0;  ///< value number an option of [[slave.value]], [[actual]] or [[reference]] belongs to
};

/// One option.
struct Option {
  std::string_view key;  ///< "section.name"; a value's options are "slave.value.name"
  OptionType type = OptionType::text;
  std::string_view initial;  ///< default in TOML's notation; in round brackets: words, no fixed default
  std::int64_t minimum = 0;  ///< smallest number; fewest bytes of a string
  std::int64_t maximum = 0;
  bool not_zero = false;     ///< number: 0 is not allowed
  std::string_view choices;  ///< separated by '|'; empty: no list
  std::string_view unit;     ///< empty: none
  bool reload = false;       ///< may change while the daemon runs
  std::string_view help;
  void (*apply)(Draft&, const Value&) = nullptr;  ///< takes a value that `mismatch` has passed

  /// Does the option have a fixed default?
  constexpr bool has_initial() const noexcept { return !initial.starts_with('('); }
};

/// Every option, section by section in the order of the documentation.
std::span<const Option> options();

/// The option of a key, e.g. "bus.name" or "slave.value.unit"; null when there is none.
const Option* find_option(std::string_view key);

/// Is `key` a section, i.e. does an option's key begin with it and a dot?
bool is_section(std::string_view key);

/// Does this section stand in double brackets, once for each slave or value?
bool is_repeated(std::string_view section);

/// What the option takes, in words: "1..31", "true or false".
std::string allowed(const Option& option);

/// Nothing when the option takes `value`; else what was found and what is allowed. Slave names are looked
/// up in `draft`.
std::optional<std::string> mismatch(const Option& option, const Value& value, const Draft& draft);

/// The configured slave of that number or name.
std::optional<cansync::SlaveNumber> find_slave(const Config& config, const Scalar& who);

/// A cursor from a value that `mismatch` has passed.
cansync::Cursor to_cursor(const Config& config, const Value& value);

}  // namespace cansyncd
