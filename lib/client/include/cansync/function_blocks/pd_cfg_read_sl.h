#pragma once

#include <string>

#include "../slave_connection.h"
#include "types.h"

namespace cansync::client::function_blocks {

/// CANsync_PD_CFG_READ_SL (M 4.17): which words of another slave's actual value telegrams belong to which
/// actual value. One for each other slave.
///
/// The mapping stands in the daemon's configuration, as a section [[monitored]]; the inputs are compared with
/// it, and `error` says what differs and what is to be written there.
class CANSYNC_PUBLIC PD_CFG_READ_SL {
 public:
  SINT si_SL_NR = 0;                         ///< the other slave, 0..31
  SINT_4_BMARRAY a_RDC1 = {-1, -1, -1, -1};  ///< [word] := actual value 0..3; -1 none
  BOOL_4_BMARRAY a_HL_RDC1 = {};             ///< [word] := TRUE high word
  SINT_4_BMARRAY a_RDC2 = {-1, -1, -1, -1};  ///< [word] := actual value 4..7; -1 none
  BOOL_4_BMARRAY a_HL_RDC2 = {};

  /// The daemon has this mapping. Not in the manual.
  bool in_effect() const noexcept { return in_effect_; }
  /// What differs, in words; empty without an error. Not in the manual.
  const std::string& error() const noexcept { return error_; }

  /// `connection` must outlive the block.
  explicit PD_CFG_READ_SL(SlaveConnection& connection) : connection_(&connection) {}
  /// One cycle: compares.
  void call();

 private:
  SlaveConnection* connection_;
  bool in_effect_ = false;
  std::string error_;
};

}  // namespace cansync::client::function_blocks
