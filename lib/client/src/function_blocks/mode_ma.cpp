#include <cansync/function_blocks/mode_ma.h>
#include <cansync/topics.h>

#include <algorithm>
#include <utility>

#include "client/src/function_blocks/option_status.h"

namespace cansync::client::function_blocks {
namespace {

constexpr std::chrono::milliseconds kAgain(500);

bool rises(BOOL input, BOOL& was) {
  return input && !std::exchange(was, input);
}

}  // namespace

void MODE_MA::enter(Mode mode) {
  entered_ = mode;
  slot_.enter([mode](Client& client) { return client.mode(mode); });
}

/// Once the input has become TRUE, its command waits for its turn.
void MODE_MA::rise(BOOL input, BOOL& was, Mode mode) {
  if (!rises(input, was)) return;
  const auto end = waiting_.begin() + static_cast<std::ptrdiff_t>(waiting_count_);
  if (std::find(waiting_.begin(), end, mode) == end) waiting_[waiting_count_++] = mode;
}

/// Enters the command that waits longest, when none is on its way.
void MODE_MA::next(WORD option_status) {
  // A line that was down and is set up again may be another program's.
  if (!is_synchronous(option_status)) {
    seen_down_ = true;
  } else if (seen_down_) {
    own_reset_ = false;
  }
  while (waiting_count_ > 0 && !slot_.open()) {
    const Mode mode = waiting_.front();
    std::shift_left(waiting_.begin(), waiting_.end(), 1);
    --waiting_count_;
    if (mode == Mode::setup && is_synchronous(option_status) && !own_reset_) continue;
    if (mode != Mode::reset_can) {
      own_reset_ = mode == Mode::restart;
      seen_down_ = false;
    }
    enter(mode);
  }
}

/// x_CANsync_RUN, behind every other command.
void MODE_MA::run(Clock::time_point now) {
  if (!run_wanted_ || slot_.open()) return;
  if (run_given_ && now - *run_given_ < kAgain) return;
  run_given_ = now;
  enter(Mode::run);
}

/// Takes what came of the command on its way.
void MODE_MA::poll() {
  const bool was_open = slot_.open();
  slot_.poll();
  if (!was_open || slot_.open()) return;
  if (entered_ == Mode::run && slot_.sent()) own_reset_ = false;
  if (entered_ == Mode::restart && slot_.cause() != RefusalCause::none) own_reset_ = false;
  if (entered_ == Mode::run) {
    // An input that has become TRUE anew meanwhile is another command.
    if (run_given_) run_wanted_ = run_wanted_ && slot_.refused() && slot_.passes();
  } else if (slot_.refused()) {
    waiting_count_ = 0;
  }
}

void MODE_MA::call(Clock::time_point now) {
  // Of a daemon that has gone no line is in any state.
  const auto status = client_->master_status(std::chrono::milliseconds(0));
  const WORD option_status = status ? status->option_status : WORD{0};
  // An input that was let go counts anew.
  reset_was_ = reset_was_ && x_RESET_SOFTWARE;
  controller_was_ = controller_was_ && x_RESET_CANsync_CONTROLLER;
  sync_was_ = sync_was_ && x_SYNC_MODE;
  run_was_ = run_was_ && x_CANsync_RUN;
  run_wanted_ = run_wanted_ && x_CANsync_RUN;

  if (x_ASYNC_MODE0 || x_ASYNC_MODE1)
    slot_.refuse(RefusalCause::field, "client: x_ASYNC_MODE0 and x_ASYNC_MODE1 are reserved; allowed FALSE");
  rise(x_RESET_CANsync_CONTROLLER, controller_was_, Mode::reset_can);
  rise(x_RESET_SOFTWARE, reset_was_, Mode::restart);
  rise(x_SYNC_MODE, sync_was_, Mode::setup);
  if (rises(x_CANsync_RUN, run_was_)) {
    run_wanted_ = true;
    run_given_.reset();
  }
  // Of a line that has not told its state yet nothing is wanted: it may run.
  if (status || !client_->daemon_present()) {
    next(option_status);
    run(now);
  }
  poll();
  show(option_status);
}

void MODE_MA::show(WORD option_status) {
  x_HS_ACTIV = option_status == kStartUp;
  x_INIT_POSSIBLE = option_status == kInitialisationPossible;
  x_WAIT = option_status == kWaiting;
  x_PREPARE_ACTIV = option_status == kSettingUp;
  x_CANsync_ACTIV = option_status == kActive;
  x_SYNC_MODE_ACTIV = x_PREPARE_ACTIV || x_CANsync_ACTIV;
  x_ASYNC_MODE_ACTIV = false;
  x_SL = false;
  x_MA = x_SYNC_MODE_ACTIV;
}

}  // namespace cansync::client::function_blocks
