#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

/// Operating states of the interface module and the commands between them (M 3.2.2.3). Pure; realtime safe.
namespace cansync {

/// Value of `w_OPTION_STATUS`.
enum class State : std::uint16_t {
  start_up = 0x0001,
  waiting_for_initialisation = 0x0002,
  waiting_for_start = 0x0003,
  setting_up_master = 0x0043,
  setting_up_slave = 0x0013,
  active_master = 0x0080,
  active_slave = 0x0020,
};

/// Value of `w_CPU_CONTROL`.
enum class ControlCommand : std::uint16_t {
  cold_restart = 0x0000,
  handshake = 0x0001,
  take_over_initialisation = 0x0002,
  start_synchronous = 0x0020,
  enable_active = 0x0040,
  reset_can = 0x0080,
};

/// Which end of the bus the module is.
enum class Role : std::uint8_t { master, slave };

/// The state that follows `command`; nothing when the command is not allowed in that state. `reset_can` keeps
/// the state. docs/cansync-protocol.md has the table; a test walks through every pair.
std::optional<State> next(Role role, State state, ControlCommand command) noexcept;

/// A short English word group for status and messages; the text lives as long as the program.
std::string_view name(State state) noexcept;
std::string_view name(ControlCommand command) noexcept;

/// True where SYNC runs and the command channel is served.
constexpr bool is_synchronous(State state) noexcept {
  return state != State::start_up && state != State::waiting_for_initialisation &&
         state != State::waiting_for_start;
}
/// True where reference and actual values are exchanged.
constexpr bool is_active(State state) noexcept {
  return state == State::active_master || state == State::active_slave;
}

}  // namespace cansync
