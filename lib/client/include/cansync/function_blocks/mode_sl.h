#pragma once

#include <string>

#include "../slave_connection.h"
#include "slave_command_slot.h"
#include "types.h"

namespace cansync::client::function_blocks {

/// CANsync_MODE_SL (M 4.11): sets the operating mode of the slave and shows its state.
///
/// Commands go out when an input becomes TRUE, once; those of one call one after the other, in the order
/// x_RESET_CANsync_CONTROLLER, x_RESET_SOFTWARE, x_SYNC_MODE, x_CANsync_RUN. One that is refused drops those
/// that wait behind it, and `error` says why. x_SYNC_MODE and x_CANsync_RUN are no commands where the slave
/// is set up, or active, already: the daemon goes as far as `slave.target` of its configuration says by
/// itself. x_CANsync_RUN waits for set-up while it stays TRUE. x_SET_INIT_DATA does nothing, because the
/// initialisation data are the daemon's configuration file; the reserved inputs are refused.
class CANSYNC_PUBLIC MODE_SL {
 public:
  BOOL x_RESET_SOFTWARE = false;            ///< cold restart, then as slave.target says
  BOOL x_SET_INIT_DATA = false;             ///< no effect
  BOOL x_CANsync_RUN = false;               ///< enables active operation
  BOOL x_RESET_CANsync_CONTROLLER = false;  ///< leaves bus-off
  BOOL x_SYNC_MODE = false;                 ///< sets up synchronous operation
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

  /// Who refused the last command and why, in words; empty without an error. Not in the manual.
  const std::string& error() const noexcept { return slot_.error(); }
  /// Why the daemon, or the block, refused it; none without a refusal. Not in the manual.
  RefusalCause cause() const noexcept { return slot_.cause(); }

  /// `connection` must outlive the block.
  explicit MODE_SL(SlaveConnection& connection) : connection_(&connection), slot_(connection) {}
  /// One cycle: gives the command of each input that has become TRUE, and shows the state that the daemon
  /// told last, at every change and once a second.
  void call();

 private:
  /// An input and its command.
  struct Input {
    BOOL was = false;
    bool wanted = false;  ///< its command waits
  };

  void look_at_inputs();
  void give(Input& input, Mode mode, bool now);

  SlaveConnection* connection_;
  SlaveCommandSlot slot_;
  Input controller_;
  Input reset_;
  Input sync_;
  Input run_;
};

}  // namespace cansync::client::function_blocks
