#include "cansync/channel/transfer_phase.h"

namespace cansync {

std::optional<TransferPhase> next(TransferPhase phase, TransferEvent event) noexcept {
  if (phase == TransferPhase::ended) return std::nullopt;
  switch (event) {
    case TransferEvent::accepted:
      if (phase == TransferPhase::initialise) return TransferPhase::body;
      break;
    case TransferEvent::bytes_taken:
      if (phase == TransferPhase::body) return TransferPhase::body;
      break;
    case TransferEvent::block_done:
      if (phase == TransferPhase::body) return TransferPhase::initialise;
      break;
    case TransferEvent::given_up:
      // Also while it is cancelled already: the telegram is sent once more.
      return TransferPhase::cancel;
    case TransferEvent::begun_again:
      // From initialise when that telegram was never sent.
      if (phase != TransferPhase::body) return TransferPhase::initialise;
      break;
    case TransferEvent::ended:
      return TransferPhase::ended;
  }
  return std::nullopt;
}

}  // namespace cansync
