#pragma once

#include "command_slot.h"
#include "types.h"

namespace cansync::client::function_blocks {

/// CANsync_CONTROLWORD_MA (M 4.7): sends a control word to one slave. Every call with x_EN = TRUE enters it
/// for sending, so set x_EN for one cycle only. The newest word replaces one that waits in the daemon; while
/// two are on their way, the newest entered one waits here. One that enables and is not sent within the
/// daemon's monitoring time ends with an error.
class CANSYNC_PUBLIC CONTROLWORD_MA {
 public:
  SINT si_SL_NR_CTRL = 0;  ///< 0..31
  WORD w_CONTROLWORD = 0;  ///< 16 bits, as the slave's manual defines them
  BOOL x_EN = false;

  BOOL x_OK = false;  ///< the control word entered last was seen on the bus

  /// Who refused the one entered last and why, in words; empty without an error. Not in the manual.
  const std::string& error() const noexcept { return slot_.error(); }
  /// Why the daemon, or the block, refused it; none without a refusal. Not in the manual.
  RefusalCause cause() const noexcept { return slot_.cause(); }

  /// `client` must outlive the block.
  explicit CONTROLWORD_MA(Client& client) : client_(&client), slot_(client, true) {}
  /// One cycle: enters the word when x_EN is TRUE, and takes the reply to the one before when it is there. A
  /// slave that is not 0..31 or not configured is refused here (`error`).
  void call();

 private:
  Client* client_;
  CommandSlot slot_;
};

}  // namespace cansync::client::function_blocks
