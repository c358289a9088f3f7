#pragma once

#include <memory>
#include <string>

#include "../../frame_connection.h"
#include "../types.h"

namespace cansync::client::function_blocks {

/// FC 67 CANCTRL (Helmholz 7.2.4): timers, controller and queues. Each call does what `Func` says.
///
/// RETVAL: 0 the daemon was asked; 80F1 no daemon is there; 80F2 too many requests are open; 82E2 no such
/// function, or timer. What the daemon made of it comes later: `open`, `error`.
class CANSYNC_PUBLIC CANCTRL {
 public:
  INT Func = 0;  ///< 1 start and 2 stop a timer; 5 reset of the controller, frames may be lost; 6 every queue
                 ///< is emptied; 7 the overflow bits are reset
  INT Param = 0;  ///< of 1 and 2 the timer, 1..16; else not looked at

  WORD STAT = 0;   ///< after each call; Helmholz 7.2.5
  INT RETVAL = 0;  ///< of this call

  /// Calls that the daemon has not answered yet; a call of any block takes answers. Not in the manual.
  UINT open() const noexcept;
  /// What RETVAL means here, or what the daemon has refused last; empty: nothing is wrong. Not in the manual.
  const std::string& error() const noexcept;

  /// `connection` must outlive the block.
  explicit CANCTRL(FrameConnection& connection);
  ~CANCTRL();
  CANCTRL(const CANCTRL&) = delete;
  CANCTRL& operator=(const CANCTRL&) = delete;

  /// Does it once.
  void call();

 private:
  struct Asked;
  INT ask();
  INT refuse(INT code, std::string reason);

  FrameConnection* connection_;
  std::shared_ptr<Asked> asked_;  ///< shared with the answers that have not come
};

}  // namespace cansync::client::function_blocks
