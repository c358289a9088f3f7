#include <cansync/function_blocks/mode_ma.h>
#include <cansync/topics.h>

#include <utility>

namespace cansync::client::function_blocks {
namespace {

constexpr std::chrono::milliseconds kAgain(500);

// Values of w_OPTION_STATUS (M 3.2.2.3).
constexpr WORD kStartUp = 0x0001;
constexpr WORD kInitialisationPossible = 0x0002;
constexpr WORD kWaiting = 0x0003;
constexpr WORD kSettingUp = 0x0043;
constexpr WORD kActive = 0x0080;

bool rises(BOOL input, BOOL& was) {
  return input && !std::exchange(was, input);
}

}  // namespace

void MODE_MA::enter(Mode mode) {
  slot_.enter([mode](Client& client) { return client.mode(mode); });
}

void MODE_MA::call(Clock::time_point now) {
  const MasterStatus status = client_->master_status();
  // An input that was let go counts anew.
  reset_was_ = reset_was_ && x_RESET_SOFTWARE;
  controller_was_ = controller_was_ && x_RESET_CANsync_CONTROLLER;
  sync_was_ = sync_was_ && x_SYNC_MODE;
  run_was_ = run_was_ && x_CANsync_RUN;
  run_wanted_ = run_wanted_ && x_CANsync_RUN;

  if (x_ASYNC_MODE0 || x_ASYNC_MODE1)
    slot_.refuse(RefusalCause::field, "client: x_ASYNC_MODE0 and x_ASYNC_MODE1 are reserved; allowed FALSE");
  if (rises(x_RESET_CANsync_CONTROLLER, controller_was_)) enter(Mode::reset_can);
  if (rises(x_RESET_SOFTWARE, reset_was_)) enter(Mode::restart);
  if (rises(x_SYNC_MODE, sync_was_)) enter(Mode::setup);
  if (rises(x_CANsync_RUN, run_was_)) {
    run_wanted_ = true;
    run_given_.reset();
  }
  // Behind every command that is on its way.
  const bool due = !run_given_ || (slot_.passes() && now - *run_given_ >= kAgain);
  if (run_wanted_ && due && !slot_.open()) {
    run_given_ = now;
    enter(Mode::run);
  }
  slot_.poll();
  if (run_given_ && slot_.sent()) run_wanted_ = false;
  show(status.option_status);
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
