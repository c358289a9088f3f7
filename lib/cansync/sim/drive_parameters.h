#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "cansync/slave/parameter_table.h"
#include "cansync/slave/slave.h"
#include "cansync/telegram/numbers.h"

namespace sim {

using cansync::ParameterDefinition;

/// Numbers of the parameters that the drive itself knows (docs/simulated-drive.md has the whole table).
namespace parameter {
inline constexpr std::uint16_t device_type = 100;        ///< word, read only: 4400
inline constexpr std::uint16_t firmware_version = 101;   ///< doubleword, read only: 0x00010000
inline constexpr std::uint16_t serial_number = 102;      ///< doubleword, read only: 1000 + slave number
inline constexpr std::uint16_t slave_number = 103;       ///< word, read only
inline constexpr std::uint16_t control_word = 300;       ///< word, read only: what arrived last
inline constexpr std::uint16_t status_word = 301;        ///< word, read only
inline constexpr std::uint16_t operating_mode = 302;     ///< word, 0 position, 1 speed
inline constexpr std::uint16_t fault_code = 303;         ///< word, read only
inline constexpr std::uint16_t missed_references = 304;  ///< doubleword, read only: intervals since power-on
inline constexpr std::uint16_t misses_in_a_row = 305;    ///< word, read only
inline constexpr std::uint16_t missed_edges = 306;       ///< doubleword, read only: SYNC edges since power-on
inline constexpr std::uint16_t position = 310;           ///< doubleword, read only, increments
inline constexpr std::uint16_t speed = 311;              ///< doubleword, read only, increments/s
inline constexpr std::uint16_t torque = 312;             ///< word, read only, 0.1 %
inline constexpr std::uint16_t following_error = 313;    ///< doubleword, read only, increments
inline constexpr std::uint16_t temperature = 314;        ///< word, read only, 0.1 degree Celsius
inline constexpr std::uint16_t position_setpoint = 315;  ///< doubleword, read only, increments
inline constexpr std::uint16_t last_action = 330;    ///< doubleword, read only: command, data byte, data word
inline constexpr std::uint16_t action_count = 331;   ///< doubleword, read only
inline constexpr std::uint16_t lag = 400;            ///< word, 0..10000, 0.1 ms
inline constexpr std::uint16_t maximum_speed = 401;  ///< doubleword, 1..2147483647, increments/s
inline constexpr std::uint16_t deceleration = 402;   ///< doubleword, 1..2147483647, increments/s^2
inline constexpr std::uint16_t torque_offset = 403;  ///< word, -1000..1000, 0.1 %
inline constexpr std::uint16_t busy = 410;           ///< word, answers busy first
inline constexpr std::uint16_t busy_replies = 411;   ///< word: how often 410 answers busy; 0xFFFF = always
inline constexpr std::uint16_t not_available = 420;  ///< word, never available
inline constexpr std::uint16_t user_doubleword = 430;          ///< doubleword without limits
inline constexpr std::uint16_t first_plain_word = 1000;        ///< 20 plain words, 1000..1019
inline constexpr std::uint16_t first_plain_doubleword = 1020;  ///< 20 plain doublewords, 1020..1039
inline constexpr std::uint16_t plain_count = 20;
}  // namespace parameter

/// The parameters a drive has unless told otherwise.
std::vector<ParameterDefinition> standard_parameters();

/// The parameters of a drive: a table, of which `parameter::busy` answers each access busy a settable number
/// of times first. All memory is taken in the constructor; nothing else allocates, blocks or throws. Not
/// thread safe.
class DriveParameters {
 public:
  explicit DriveParameters(const std::vector<ParameterDefinition>& definitions) : table_(definitions) {}

  cansync::ParameterAnswer read(cansync::ParameterNumber number, cansync::Element element) noexcept;
  cansync::ParameterAnswer write(cansync::ParameterNumber number, bool doubleword,
                                 std::uint32_t value) noexcept;

  /// The access answered busy last is no longer wanted: the next one counts from the start.
  void dropped() noexcept { busy_given_ = 0; }

  /// How often an access to `parameter::busy` is answered busy; `kEndless`: always.
  void set_busy_replies(std::uint32_t replies) noexcept { busy_replies_ = replies; }
  static constexpr std::uint32_t kEndless = 0xFFFFFFFF;

  std::optional<std::uint32_t> value(std::uint16_t number) const noexcept { return table_.value(number); }
  bool set_value(std::uint16_t number, std::uint32_t value) noexcept {
    return table_.set_value(number, value);
  }

  /// Every parameter back to its value at power-on.
  void reset() noexcept;

 private:
  bool still_busy(cansync::ParameterNumber number) noexcept;

  cansync::ParameterTable table_;
  std::uint32_t busy_replies_ = 0;
  std::uint32_t busy_given_ = 0;
};

}  // namespace sim
