// How the realtime loop follows an external SYNC, and what it tells about the SYNC line.
#include <algorithm>

#include "daemon/cansync/realtime/realtime_loop.h"

namespace cansyncd {

/// Once an interval: hands the input's edges to the timeline and reports changes, on the edge.
void RealtimeLoop::follow_sync() noexcept {
  if (loop_.sync_line == nullptr) return;
  if (sync_line::PhaseLock* lock = timeline_.lock()) {
    loop_.sync_line->follow(*lock);
    const sync_line::LockState before = line_.state;
    const can::Time missing = line_.holdover;
    line_.state = lock->state();
    line_.phase_error = lock->phase_error();
    line_.holdover = lock->holdover();
    line_.edges = lock->counters().accepted;
    line_.rejected_edges = lock->counters().rejected;
    if (line_.state != before) {
      const can::Time longest = std::max(missing, line_.holdover);
      reporter_.report(SyncSourceChanged{reporter_.moment(), before, line_.state, longest});
    }
  }
  line_.output_failures = loop_.sync_line->output_failures();
  watch_sync_device(true, loop_.sync_line->output_error(), sync_output_error_);
  watch_sync_device(false, loop_.sync_line->input_error(), sync_input_error_);
}

void RealtimeLoop::watch_sync_device(bool output, int error, int& known) noexcept {
  if (error == known) return;
  known = error;
  reporter_.report(SyncDeviceChanged{reporter_.moment(), output, error, line_.output_failures});
}

}  // namespace cansyncd
