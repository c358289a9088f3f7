#pragma once

#include "../slave_connection.h"
#include "types.h"

namespace cansync::client::function_blocks {

/// CANsync_CONTROLWORD_SL (M 4.8): receives the master's control word. Of several that came between two calls
/// the newest counts.
class CANSYNC_PUBLIC CONTROLWORD_SL {
 public:
  WORD w_CONTROLWORD = 0;  ///< changes with a receipt only
  SINT si_RECEIVED = 0;    ///< 2: a control word came since the last call; else 0

  UDINT ud_RECEIPTS = 0;  ///< how many came since the last call. Not in the manual.

  /// `connection` must outlive the block. What came before does not count.
  explicit CONTROLWORD_SL(SlaveConnection& connection);
  /// One cycle.
  void call();

 private:
  SlaveConnection* connection_;
  std::uint64_t seen_;
};

}  // namespace cansync::client::function_blocks
