#pragma once

#include "parameter_block.h"

namespace cansync::client::function_blocks {

/// CANsync_PAR_WRITE_MA (M 4.14): writes a parameter of a slave. A value that is too wide for a word with
/// x_PAR_FORMAT = FALSE is refused (b_ERR bit 0), not cut. A write is sent once: with b_ERR bit 1 it is not
/// known whether the slave took the value.
class CANSYNC_PUBLIC PAR_WRITE_MA : public ParameterBlock {
 public:
  UDINT ud_PAR_VALUE = 0;  ///< raw value to be written

  /// `client` must outlive the block.
  explicit PAR_WRITE_MA(Client& client) : ParameterBlock(client) {}
  /// One cycle: begins, follows or gives up the job. `now` counts t_TIME.
  void call(Clock::time_point now = Clock::now());
};

}  // namespace cansync::client::function_blocks
