#pragma once

#include <cstdint>

#include "sync/phase_lock.h"

namespace sync_line {

/// Where edges of an external SYNC come from. Realtime thread; nothing allocates, locks, waits or throws.
class Input {
 public:
  virtual ~Input() = default;

  /// Takes the oldest edge not taken yet; false when there is none. `at` is on CLOCK_MONOTONIC. `near`: the
  /// timeline's next edge on that clock.
  virtual bool take(Time near, Time& at) noexcept = 0;

  /// Why the device cannot be read now, as an error number; 0: it can.
  virtual int error() const noexcept = 0;
};

/// Which electrical edge counts.
enum class Edge : std::uint8_t { falling, rising };

}  // namespace sync_line
