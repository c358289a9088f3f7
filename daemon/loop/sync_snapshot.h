#pragma once

#include <cstdint>

#include "can/bus.h"
#include "sync/phase_lock.h"

namespace cansyncd {

/// The SYNC line; all zero when nothing is followed and nothing failed.
struct SyncSnapshot {
  sync_line::LockState state = sync_line::LockState::searching;  ///< only with an input or a hardware clock
  can::Time phase_error{0};                                      ///< input after timeline, filtered
  can::Time holdover{0};                                         ///< for how long edges have been missing
  std::uint64_t edges = 0;                                       ///< of the input, used
  std::uint64_t rejected_edges = 0;                              ///< of the input, not used
  std::uint64_t output_failures = 0;                             ///< edges that could not be made
};

}  // namespace cansyncd
