#pragma once

#include <string>

#include "../slave_connection.h"
#include "types.h"

namespace cansync::client::function_blocks {

/// CANsync_PD_CFG_SL (M 4.18): which words of the reference value telegrams belong to which reference value,
/// and which words of which actual value stand where in this slave's actual value telegrams.
///
/// The mapping stands in the daemon's configuration; the inputs are compared with it, and `error` says what
/// differs and what is to be written there. As the manual says, nobody compares it with the master's.
class CANSYNC_PUBLIC PD_CFG_SL {
 public:
  SINT_4_BMARRAY a_WRC1 = {-1, -1, -1, -1};  ///< [word] := reference value 0..3; -1 none
  BOOL_4_BMARRAY a_HL_WRC1 = {};             ///< [word] := TRUE high word
  SINT_4_BMARRAY a_WRC2 = {-1, -1, -1, -1};  ///< [word] := reference value 4..7; -1 none
  BOOL_4_BMARRAY a_HL_WRC2 = {};
  SINT_4_BMARRAY a_RDC1 = {-1, -1, -1, -1};  ///< [word] := actual value 0..3; -1 none
  BOOL_4_BMARRAY a_HL_RDC1 = {};
  SINT_4_BMARRAY a_RDC2 = {-1, -1, -1, -1};  ///< [word] := actual value 4..7; -1 none
  BOOL_4_BMARRAY a_HL_RDC2 = {};

  /// The daemon has this mapping. Not in the manual.
  bool in_effect() const noexcept { return in_effect_; }
  /// What differs, in words; empty without an error. Not in the manual.
  const std::string& error() const noexcept { return error_; }

  /// `connection` must outlive the block.
  explicit PD_CFG_SL(SlaveConnection& connection) : connection_(&connection) {}
  /// One cycle: compares.
  void call();

 private:
  SlaveConnection* connection_;
  bool in_effect_ = false;
  std::string error_;
};

}  // namespace cansync::client::function_blocks
