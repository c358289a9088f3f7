#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>

#include "command_slot.h"
#include "types.h"

namespace cansync::client::function_blocks {

/// CANsync_MODE_MA (M 4.10): sets the operating mode and shows the state.
///
/// Commands go out when an input becomes TRUE, once; those of several inputs one after the other, in the
/// order in which they rose, in one call x_RESET_CANsync_CONTROLLER, x_RESET_SOFTWARE, x_SYNC_MODE. One that
/// is refused drops those that wait behind it, and `error` says why. x_SYNC_MODE while the line is set up or
/// active is no command, because the line may be another program's; it is one after x_RESET_SOFTWARE of this
/// block, until the line is set up or enabled again, by whomever. x_CANsync_RUN is given again every 500 ms
/// while it stays TRUE and the daemon refuses it for what passes (`retry`), because it enables active
/// operation only when the slaves are ready; what does not pass, as a daemon that changes nothing, ends it.
/// It goes behind every other command. x_SET_INIT_DATA does nothing, because the initialisation data are the
/// daemon's configuration file; the reserved inputs x_ASYNC_MODE0 and 1 are refused. The outputs show what
/// the daemon told last. x_HS_ACTIV is the state start-up (0x0001).
class CANSYNC_PUBLIC MODE_MA {
 public:
  BOOL x_RESET_SOFTWARE = false;            ///< the daemon starts the line anew, up to the configured state
  BOOL x_SET_INIT_DATA = false;             ///< no effect
  BOOL x_CANsync_RUN = false;               ///< enables active operation
  BOOL x_RESET_CANsync_CONTROLLER = false;  ///< leaves bus-off
  BOOL x_SYNC_MODE = false;                 ///< sets up synchronous operation
  BOOL x_ASYNC_MODE0 = false;               ///< reserved
  BOOL x_ASYNC_MODE1 = false;               ///< reserved

  BOOL x_HS_ACTIV = false;
  BOOL x_INIT_POSSIBLE = false;
  BOOL x_WAIT = false;
  BOOL x_PREPARE_ACTIV = false;
  BOOL x_CANsync_ACTIV = false;
  BOOL x_SYNC_MODE_ACTIV = false;
  BOOL x_ASYNC_MODE_ACTIV = false;  ///< never
  BOOL x_SL = false;                ///< never: the daemon is the master
  BOOL x_MA = false;

  /// Who refused the last command and why, in words; empty without an error. Not in the manual.
  const std::string& error() const noexcept { return slot_.error(); }
  /// Why the daemon, or the block, refused it; none without a refusal. Not in the manual.
  RefusalCause cause() const noexcept { return slot_.cause(); }

  /// `client` must outlive the block.
  explicit MODE_MA(Client& client) : client_(&client), slot_(client) {}
  /// One cycle: enters a command for each input that has become TRUE, and shows the state. `now` counts the
  /// 500 ms.
  void call(Clock::time_point now = Clock::now());

 private:
  void enter(Mode mode);
  void rise(BOOL input, BOOL& was, Mode mode);
  void next(WORD option_status);
  void run(Clock::time_point now);
  void poll();
  void show(WORD option_status);

  Client* client_;
  CommandSlot slot_;
  BOOL reset_was_ = false;
  BOOL controller_was_ = false;
  BOOL sync_was_ = false;
  BOOL run_was_ = false;
  std::array<Mode, 3> waiting_ = {};  ///< commands of inputs that rose, each once, oldest first
  std::size_t waiting_count_ = 0;
  Mode entered_ = Mode::stop;  ///< the command on its way, or the last one
  bool own_reset_ = false;     ///< this block has started the line anew, and nobody has set it up since
  bool seen_down_ = false;     ///< likewise: it was seen not to be set up
  bool run_wanted_ = false;
  std::optional<Clock::time_point> run_given_;
};

}  // namespace cansync::client::function_blocks
