#include "j1939/claim_state.h"

namespace j1939 {

std::optional<ClaimState> next(ClaimState state, ClaimEvent event) noexcept {
  switch (event) {
    case ClaimEvent::ask:
      return ClaimState::asking;
    case ClaimEvent::claim:
      return ClaimState::claiming;
    case ClaimEvent::none_left:
      if (state != ClaimState::listening && state != ClaimState::cannot_claim)
        return ClaimState::cannot_claim;
      break;
    case ClaimEvent::undisturbed:
      if (state == ClaimState::claiming) return ClaimState::claimed;
      break;
  }
  return std::nullopt;
}

std::string_view name(ClaimState state) noexcept {
  switch (state) {
    case ClaimState::listening:
      return "listening";
    case ClaimState::asking:
      return "asking";
    case ClaimState::claiming:
      return "claiming";
    case ClaimState::claimed:
      return "claimed";
    case ClaimState::cannot_claim:
      break;
  }
  return "cannot-claim";
}

std::string_view name(ClaimEvent event) noexcept {
  switch (event) {
    case ClaimEvent::ask:
      return "ask";
    case ClaimEvent::claim:
      return "claim";
    case ClaimEvent::none_left:
      return "none left";
    case ClaimEvent::undisturbed:
      break;
  }
  return "undisturbed";
}

}  // namespace j1939
