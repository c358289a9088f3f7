#include <cansync/function_blocks/mode_sl.h>

#include "client/src/function_blocks/option_status.h"
#include "client/src/slave_side.h"

namespace cansync::client::function_blocks {

void MODE_SL::call() {
  detail::SlaveSide& side = connection_->side();
  side.look();
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
  error_ = there ? obstacle() : "client: no daemon serves the bus";
}

/// Why a command that is wanted has no effect; empty: it has, or none is wanted.
std::string MODE_SL::obstacle() const {
  if (x_ASYNC_MODE0 || x_ASYNC_MODE1)
    return "client: x_ASYNC_MODE0 and x_ASYNC_MODE1 are reserved; allowed FALSE";
  if (x_RESET_SOFTWARE)
    return "client: x_RESET_SOFTWARE: a program does not restart the slave; restart the service of the daemon";
  if (x_RESET_CANsync_CONTROLLER)
    return "client: x_RESET_CANsync_CONTROLLER: a program does not reset the controller; restart-ms of the "
           "interface ends bus-off";
  if (x_WAIT && x_SYNC_MODE)
    return "client: x_SYNC_MODE: the daemon has slave.target = \"none\"; write \"active\" there";
  if (!x_CANsync_ACTIV && (x_WAIT || x_PREPARE_ACTIV) && x_CANsync_RUN)
    return "client: x_CANsync_RUN: the slave is not active; slave.target of the daemon must be \"active\"";
  return {};
}

}  // namespace cansync::client::function_blocks
