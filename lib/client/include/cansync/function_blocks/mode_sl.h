#pragma once

#include <string>

#include "../slave_connection.h"
#include "types.h"

namespace cansync::client::function_blocks {

/// CANsync_MODE_SL (M 4.11): shows the state of the slave.
///
/// The daemon sets its mode by itself, as `slave.target` of its configuration says, and no program changes
/// it. x_SYNC_MODE and x_CANsync_RUN are fulfilled, or `error` says that the daemon is configured otherwise;
/// x_SET_INIT_DATA has no effect. The two resets are refused: the service is restarted, and restart-ms of the
/// interface ends bus-off.
class CANSYNC_PUBLIC MODE_SL {
 public:
  BOOL x_RESET_SOFTWARE = false;            ///< refused
  BOOL x_SET_INIT_DATA = false;             ///< no effect
  BOOL x_CANsync_RUN = false;               ///< active operation is wanted
  BOOL x_RESET_CANsync_CONTROLLER = false;  ///< refused
  BOOL x_SYNC_MODE = false;                 ///< synchronous operation is wanted
  BOOL x_ASYNC_MODE0 = false;               ///< reserved
  BOOL x_ASYNC_MODE1 = false;               ///< reserved

  BOOL x_HS_ACTIV = false;          ///< start-up
  BOOL x_INIT_POSSIBLE = false;     ///< initialisation is possible
  BOOL x_WAIT = false;              ///< waits for the operating mode
  BOOL x_PREPARE_ACTIV = false;     ///< set-up
  BOOL x_CANsync_ACTIV = false;     ///< active operation
  BOOL x_SYNC_MODE_ACTIV = false;   ///< synchronous operation: set-up or active
  BOOL x_ASYNC_MODE_ACTIV = false;  ///< never
  BOOL x_SL = false;                ///< slave; FALSE while no daemon is there, as all outputs
  BOOL x_MA = false;                ///< never

  /// What was refused and what helps; empty without an error. Not in the manual.
  const std::string& error() const noexcept { return error_; }

  /// `connection` must outlive the block.
  explicit MODE_SL(SlaveConnection& connection) : connection_(&connection) {}
  /// One cycle. The state is what the daemon told last, at every change and once a second.
  void call();

 private:
  std::string obstacle() const;

  SlaveConnection* connection_;
  std::string error_;
};

}  // namespace cansync::client::function_blocks
