#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "cansync/slave/slave.h"
#include "cansync/telegram/errors.h"
#include "cansync/telegram/numbers.h"

namespace cansync {

/// One parameter of a slave.
struct ParameterDefinition {
  /// What a master may do with it.
  enum class Access : std::uint8_t {
    read_write,
    read_only,      ///< a write is answered "not changeable"
    not_available,  ///< every access is answered "data not available now"
  };
  std::uint16_t number = 0;  ///< 0..4095
  bool doubleword = false;   ///< format: 32 bits, else 16
  Access access = Access::read_write;
  std::uint32_t initial = 0;    ///< raw value at the start
  std::int64_t minimum = 0;     ///< below zero: the value is signed
  std::int64_t maximum = 0;     ///< inclusive
  bool limited = false;         ///< `minimum` and `maximum` hold, and can be read as elements 0 and 1
  bool by_application = false;  ///< an application answers for the value (`ParameterJobs`)
  /// What every access is answered with while no application has taken the number over; none: the table.
  ParameterError without_application = ParameterError::none;
};

/// The parameters of a slave: values, formats, limits, access rights (M 3.2.3.7). All memory is taken in the
/// constructor; nothing else allocates, blocks or throws. Not thread safe.
class ParameterTable {
 public:
  /// Numbers over 4095 are left out; of two definitions of one number the later one counts.
  explicit ParameterTable(const std::vector<ParameterDefinition>& definitions);

  /// What is known of a number; null: there is no such parameter.
  const ParameterDefinition* definition(std::uint16_t number) const noexcept;

  /// Reads element 7 (value), 2 (value at the start), or of a limited parameter 0 (minimum) and 1 (maximum).
  ParameterAnswer read(ParameterNumber number, Element element) const noexcept;

  /// Whether this could be written, checking access, format and limits in this order; changes nothing.
  ParameterAnswer check(ParameterNumber number, bool doubleword, std::uint32_t value) const noexcept;

  /// Writes the value when `check` finds nothing wrong.
  ParameterAnswer write(ParameterNumber number, bool doubleword, std::uint32_t value) noexcept;

  /// The raw value, past every access right; nothing when there is no such parameter.
  std::optional<std::uint32_t> value(std::uint16_t number) const noexcept;

  /// Sets the raw value, past every access right and limit; words take the lower 16 bits. False: no such
  /// parameter.
  bool set_value(std::uint16_t number, std::uint32_t value) noexcept;

  /// Every parameter back to its value at the start.
  void reset() noexcept;

 private:
  struct Entry {
    ParameterDefinition definition;
    std::uint32_t value = 0;
  };

  const Entry* find(std::uint16_t number) const noexcept;
  Entry* find(std::uint16_t number) noexcept;

  std::vector<Entry> entries_;  ///< by number
};

}  // namespace cansync
