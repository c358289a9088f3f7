#include "cansync/supervision/slave_state.h"

namespace cansync {

std::optional<SlaveState> next(SlaveState state, SlaveEvent event) noexcept {
  const bool answers = state != SlaveState::absent && state != SlaveState::lost;
  switch (event) {
    case SlaveEvent::begun:
      return SlaveState::absent;
    case SlaveEvent::answered:
      if (state == SlaveState::absent) return SlaveState::starting;
      if (state == SlaveState::lost) return SlaveState::returning;
      break;
    case SlaveEvent::gone:
      if (answers) return SlaveState::lost;
      break;
    case SlaveEvent::synchronized:
      if (state == SlaveState::starting) return SlaveState::released;
      // Its list of parameters comes first.
      if (state == SlaveState::returning) return SlaveState::returning;
      break;
    case SlaveEvent::not_synchronized:
      if (state == SlaveState::released || state == SlaveState::checking || state == SlaveState::held) {
        return SlaveState::returning;
      }
      break;
    case SlaveEvent::check_begun:
      if (is_held_out(state)) return SlaveState::checking;
      break;
    case SlaveEvent::check_passed:
      if (is_held_out(state)) return SlaveState::released;
      break;
    case SlaveEvent::check_failed:
      if (state == SlaveState::checking) return SlaveState::held;
      break;
    case SlaveEvent::asked_who:
      if (state == SlaveState::starting) return SlaveState::starting;
      if (is_held_out(state)) return SlaveState::returning;
      break;
    case SlaveEvent::duplicated:
      if (answers) return SlaveState::held;
      break;
    case SlaveEvent::wrong_drive:
      if (state == SlaveState::starting || state == SlaveState::returning) return SlaveState::held;
      break;
  }
  return std::nullopt;
}

}  // namespace cansync
