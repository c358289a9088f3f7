#pragma once

#include <string>

#include "../../frame_connection.h"
#include "../types.h"

namespace cansync::client::function_blocks {

/// SFB 403 CAN_CFG (Saia 4.2.1): begins anew. What SFB 402, 412 and 413 have set up on this connection is
/// taken back; before the first call they are refused.
///
/// Each call does it. Bit rate and bit timing are the interface's: Baudrate is compared with the daemon's,
/// TimeSeg1 is checked and has no effect. RetVal: 0000; 80A0 no daemon is there, or it has another bit rate;
/// 8187 PortID; 8190 TimeSeg1, or the number of a routine; 8191 Baudrate.
class CANSYNC_PUBLIC CAN_CFG {
 public:
  INT PortID = 0;     ///< 0
  INT TimeSeg1 = 8;   ///< 7..14 (not with 1 Mbit/s), 258..262
  DINT Baudrate = 0;  ///< bit/s: 10000, 20000, 50000, 100000, 125000, 250000, 500000, 1000000
  INT RxIntOB = 0;    ///< routine for reception of objects: 40..47; 0: none
  INT TxIntOB = 0;    ///< likewise for sending
  WORD RxIntPrm = 0;  ///< what that routine is told
  WORD TxIntPrm = 0;  ///< likewise
  WORD RetVal = 0;    ///< of this call

  /// What RetVal means here; empty: 0000. Not in the manual.
  const std::string& error() const noexcept { return error_; }

  /// `connection` must outlive the block.
  explicit CAN_CFG(FrameConnection& connection) : connection_(&connection) {}
  /// Does it once.
  void call();

 private:
  WORD configure();
  WORD refuse(WORD code, std::string reason);

  FrameConnection* connection_;
  std::string error_;
};

}  // namespace cansync::client::function_blocks
