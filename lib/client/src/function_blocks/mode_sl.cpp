#include <cansync/function_blocks/mode_sl.h>

#include "client/src/cansync_slave/slave_side.h"
#include "client/src/function_blocks/option_status.h"

namespace cansync::client::function_blocks {

/// An input that has become TRUE wants its command once.
void MODE_SL::look_at_inputs() {
  const auto look = [](BOOL input, Input& seen) {
    seen.wanted = input && (seen.wanted || !seen.was);
    seen.was = input;
  };
  look(x_RESET_CANsync_CONTROLLER, controller_);
  look(x_RESET_SOFTWARE, reset_);
  look(x_SYNC_MODE, sync_);
  look(x_CANsync_RUN, run_);
  // What the slave is already is no command; after a restart it is what comes of that.
  if (!reset_.wanted && !slot_.open()) {
    if (x_SYNC_MODE_ACTIV) sync_.wanted = false;
    if (x_CANsync_ACTIV) run_.wanted = false;
  }
}

/// One command at a time.
void MODE_SL::give(Input& input, Mode mode, bool now) {
  if (!input.wanted || !now || slot_.open()) return;
  input.wanted = false;
  slot_.mode(mode);
}

void MODE_SL::call() {
  detail::SlaveSide& side = connection_->side();
  side.look();
  const bool was_open = slot_.open();
  slot_.poll();
  if (was_open && slot_.refused()) controller_.wanted = reset_.wanted = sync_.wanted = run_.wanted = false;
  const bool there = side.daemon_present();
  const WORD status = there ? side.status().option_status : WORD{0};
  x_HS_ACTIV = status == kStartUp;
  x_INIT_POSSIBLE = status == kInitialisationPossible;
  x_WAIT = status == kWaiting;
  x_PREPARE_ACTIV = status == kSettingUpSlave;
  x_CANsync_ACTIV = status == kActiveSlave;
  x_SYNC_MODE_ACTIV = x_PREPARE_ACTIV || x_CANsync_ACTIV;
  x_ASYNC_MODE_ACTIV = false;
  x_SL = there;
  x_MA = false;
  if (!there) return slot_.refuse(RefusalCause::other_daemon, "client: no daemon serves the bus");
  if (x_ASYNC_MODE0 || x_ASYNC_MODE1)
    return slot_.refuse(RefusalCause::field,
                        "client: x_ASYNC_MODE0 and x_ASYNC_MODE1 are reserved; allowed FALSE");
  if (slot_.cause() == RefusalCause::other_daemon && !slot_.open()) slot_.clear();
  look_at_inputs();
  give(controller_, Mode::reset_can, true);
  give(reset_, Mode::restart, true);
  give(sync_, Mode::setup, x_WAIT);
  give(run_, Mode::run, x_PREPARE_ACTIV);
}

}  // namespace cansync::client::function_blocks
