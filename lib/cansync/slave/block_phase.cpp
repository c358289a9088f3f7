#include "cansync/slave/block_phase.h"

namespace cansync {

std::optional<BlockPhase> next(BlockPhase phase, BlockEvent event) noexcept {
  switch (event) {
    case BlockEvent::later:
      if (phase != BlockPhase::open) return BlockPhase::beginning;
      break;
    case BlockEvent::begun:
      if (phase != BlockPhase::open) return BlockPhase::open;
      break;
    case BlockEvent::over:
      if (phase == BlockPhase::open) return BlockPhase::beginning;
      break;
    case BlockEvent::ended:
      if (phase != BlockPhase::none) return BlockPhase::none;
      break;
  }
  return std::nullopt;
}

std::string_view name(BlockPhase phase) noexcept {
  switch (phase) {
    case BlockPhase::none:
      return "none";
    case BlockPhase::beginning:
      return "beginning";
    case BlockPhase::open:
      break;
  }
  return "open";
}

std::string_view name(BlockEvent event) noexcept {
  switch (event) {
    case BlockEvent::later:
      return "later";
    case BlockEvent::begun:
      return "begun";
    case BlockEvent::over:
      return "over";
    case BlockEvent::ended:
      break;
  }
  return "ended";
}

}  // namespace cansync
