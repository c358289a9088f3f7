#pragma once

#include "../export.h"

namespace cansync::client::function_blocks {

/// What the inputs x_EN and x_RESET mean for a block that runs jobs (M 4.12, 4.14, 4.24): x_EN = TRUE starts
/// a job and must stay until x_BUSY drops, else the job is given up. After that, and after an error, nothing
/// starts until x_RESET was TRUE. After success the next job starts when x_EN was FALSE in between: the
/// manual does not say what x_EN = TRUE means then, and a job that starts again and again by itself is what
/// nobody wants.
class CANSYNC_PUBLIC Enable {
 public:
  /// What the block has to do in this cycle.
  enum class Act {
    nothing,
    start,    ///< a job begins with this call
    proceed,  ///< the job is on its way
    abort,    ///< the job is given up
    reset,    ///< outputs are cleared, and a job on its way is given up
  };

  /// Once a cycle.
  Act call(bool x_en, bool x_reset) noexcept {
    if (x_reset) {
      phase_ = Phase::idle;
      return Act::reset;
    }
    switch (phase_) {
      case Phase::idle:
        if (!x_en) return Act::nothing;
        phase_ = Phase::busy;
        return Act::start;
      case Phase::busy:
        if (x_en) return Act::proceed;
        phase_ = Phase::locked;
        return Act::abort;
      case Phase::done:
        if (!x_en) phase_ = Phase::idle;
        return Act::nothing;
      case Phase::locked:
        break;
    }
    return Act::nothing;
  }

  /// The job has ended.
  void ended(bool ok) noexcept { phase_ = ok ? Phase::done : Phase::locked; }

 private:
  enum class Phase { idle, busy, done, locked };
  Phase phase_ = Phase::idle;
};

}  // namespace cansync::client::function_blocks
