#include "cansync/settings/mode.h"

namespace cansync {

std::optional<State> next(Role role, State state, ControlCommand command) noexcept {
  const State setting_up = role == Role::master ? State::setting_up_master : State::setting_up_slave;
  const State active = role == Role::master ? State::active_master : State::active_slave;
  const bool other_role = role == Role::master
                              ? state == State::setting_up_slave || state == State::active_slave
                              : state == State::setting_up_master || state == State::active_master;
  if (other_role) return std::nullopt;
  switch (command) {
    case ControlCommand::cold_restart:
      return State::start_up;
    case ControlCommand::reset_can:
      return state;
    case ControlCommand::handshake:
      if (state == State::start_up) return State::waiting_for_initialisation;
      break;
    case ControlCommand::take_over_initialisation:
      if (state == State::waiting_for_initialisation) return State::waiting_for_start;
      break;
    case ControlCommand::start_synchronous:
      // From active operation: the mode may be changed again after a start (M 3.2.2.3).
      if (state == State::waiting_for_start || state == active) return setting_up;
      break;
    case ControlCommand::enable_active:
      if (state == setting_up) return active;
      break;
  }
  return std::nullopt;
}

}  // namespace cansync
