#pragma once

#include "actual_value_inbox.h"
#include "types.h"

namespace cansync::client::function_blocks {

/// CANsync_PD_COMM_READ_MA (M 4.20): the actual values of one slave. "Received" is what came since the last
/// call, where the option module means the last interval; the first telegram is not told, because it may be
/// an old one that the daemon kept.
class CANSYNC_PUBLIC PD_COMM_READ_MA {
 public:
  SINT si_SL_NR = 0;  ///< 0..31; with any other number nothing is ever received

  DINT_8_BMARRAY a_RD_VALUES = {};  ///< 0..3 from telegram 1, 4..7 from telegram 2
  SINT si_RD_SL_NR1_RECEIVED = 0;   ///< 1: telegram 1 came; 0: it did not
  SINT si_RD_SL_NR2_RECEIVED = 0;   ///< 2: telegram 2 came; 0: it did not

  /// Throws SetupError.
  explicit PD_COMM_READ_MA(Client& client) : inbox_(client) {}
  /// One cycle: takes what came since the last call; values that did not come stay as they were.
  void call();

 private:
  ActualValueInbox inbox_;
};

}  // namespace cansync::client::function_blocks
