#pragma once

#include <array>
#include <cstdint>

#include "../slave_connection.h"
#include "types.h"

namespace cansync::client::function_blocks {

/// CANsync_PD_COMM_READ_SL (M 4.21): actual values of one other slave that the daemon listens to. For
/// compatibility: PD_COMM_SL with x_COPY_TO_RD_ARRAY gives them all.
class CANSYNC_PUBLIC PD_COMM_READ_SL {
 public:
  SINT si_SL_NR = 0;                ///< 0..31
  DINT_8_BMARRAY a_RD_VALUES = {};  ///< 0..3 change with RDC1 only, 4..7 with RDC2 only

  SINT si_RD_SL_NR1_RECEIVED = 0;  ///< 1: RDC1 came since the last call; else 0
  SINT si_RD_SL_NR2_RECEIVED = 0;  ///< 2: RDC2 came since the last call; else 0

  /// `connection` must outlive the block. What came before does not count.
  explicit PD_COMM_READ_SL(SlaveConnection& connection);
  /// One cycle.
  void call();

 private:
  SlaveConnection* connection_;
  std::array<std::array<std::uint64_t, 2>, 32> seen_ = {};
};

}  // namespace cansync::client::function_blocks
