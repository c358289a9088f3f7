#include "j1939/session_state.h"

namespace j1939 {

std::optional<SessionState> next(SessionState state, SessionEvent event) noexcept {
  const bool takes_packets = state == SessionState::packet || state == SessionState::window;
  switch (event) {
    case SessionEvent::begun:
      if (state == SessionState::free) return SessionState::packet;
      break;
    case SessionEvent::asked:
      if (takes_packets) return SessionState::packet;
      break;
    case SessionEvent::asked_extended:
      if (takes_packets) return SessionState::offset;
      break;
    case SessionEvent::offset_came:
      if (state == SessionState::offset) return SessionState::packet;
      break;
    case SessionEvent::packet_missing:
      if (takes_packets) return SessionState::window;
      break;
    case SessionEvent::ended:
      if (state != SessionState::free) return SessionState::free;
      break;
  }
  return std::nullopt;
}

std::string_view name(SessionState state) noexcept {
  switch (state) {
    case SessionState::free:
      return "free";
    case SessionState::packet:
      return "packet";
    case SessionState::offset:
      return "offset";
    case SessionState::window:
      break;
  }
  return "window";
}

std::string_view name(SessionEvent event) noexcept {
  switch (event) {
    case SessionEvent::begun:
      return "begun";
    case SessionEvent::asked:
      return "asked";
    case SessionEvent::asked_extended:
      return "asked, extended";
    case SessionEvent::offset_came:
      return "offset came";
    case SessionEvent::packet_missing:
      return "packet missing";
    case SessionEvent::ended:
      break;
  }
  return "ended";
}

}  // namespace j1939
