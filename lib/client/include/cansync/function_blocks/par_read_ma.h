#pragma once

#include "parameter_block.h"

namespace cansync::client::function_blocks {

/// CANsync_PAR_READ_MA (M 4.12): reads a parameter of a slave.
class CANSYNC_PUBLIC PAR_READ_MA : public ParameterBlock {
 public:
  UDINT ud_PAR_VALUE = 0;          ///< raw; keeps its value until the next one is read
  BOOL x_PAR_FORMAT_READ = false;  ///< format of the value read: TRUE doubleword

  /// `client` must outlive the block.
  explicit PAR_READ_MA(Client& client) : ParameterBlock(client) {}
  /// One cycle: begins, follows or gives up the job. `now` counts t_TIME.
  void call(Clock::time_point now = Clock::now());
};

}  // namespace cansync::client::function_blocks
