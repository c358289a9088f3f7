#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

/// How far the master may use a slave, and what changes that. Pure; realtime safe.
namespace cansync {

/// How far a slave may be used.
enum class SlaveState : std::uint8_t {
  absent,     ///< has not answered since synchronous operation began
  starting,   ///< answers for the first time; not yet synchronized, or not known to be the drive expected
  released,   ///< answers and is synchronized
  lost,       ///< stopped answering; its jobs are refused
  returning,  ///< answers again, or lost SYNC; not yet synchronized (again), or not known to be the drive
              ///< expected. Held out
  checking,   ///< synchronized again; its list of parameters is checked or written. Held out
  held,       ///< not the drive expected, or two drives, or its list was not passed. Held out until it is
              ///< released or checked again by command
};
inline constexpr unsigned kSlaveStates = 7;

/// What supervision finds out about a configured slave, or is told to do with it.
enum class SlaveEvent : std::uint8_t {
  begun,             ///< synchronous operation begins: nothing is known of it
  answered,          ///< a command was answered, the first one since it began or was lost
  gone,              ///< given up after unanswered commands, or the bus is gone, and it had answered
  synchronized,      ///< its status word says so, and did not before
  not_synchronized,  ///< its status word says so, and did not before
  check_begun,       ///< its list of parameters is gone through, by itself or by command
  check_passed,      ///< the list is right or empty, or the slave is released by command without it
  check_failed,      ///< a parameter of the list is not right
  asked_who,         ///< what tells who it is begins to be read
  wrong_drive,       ///< it is not the drive expected
  duplicated,        ///< two drives answer as this slave
};
inline constexpr unsigned kSlaveEvents = 11;

/// The state that follows `event`, which may be the same; nothing when the event cannot come in that state
/// and so changes nothing. docs/cansync-protocol.md has the table; a test walks through every pair.
std::optional<SlaveState> next(SlaveState state, SlaveEvent event) noexcept;

/// English words for status, logs and documents, one for a state; the text lives as long as the program.
std::string_view name(SlaveState state) noexcept;
std::string_view name(SlaveEvent event) noexcept;

/// True for a slave that was away and must not yet be used with references.
constexpr bool is_held_out(SlaveState state) noexcept {
  return state == SlaveState::returning || state == SlaveState::checking || state == SlaveState::held;
}

}  // namespace cansync
