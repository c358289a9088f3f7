#pragma once

#include <string>

#include "../../frame_connection.h"
#include "../types.h"

namespace cansync::client::function_blocks {

/// SFB 412 CAN_CFGQ (Saia 4.2.3): sets up the receive and the send queue of the connection, anew with each
/// call; what waited is gone. The receive queue gets what the daemon's filters and MsgID with Mask take.
///
/// RetVal: 0000; 80A0 no daemon is there, or CAN_CFG was not called; 80C3 a depth over 1000; 8187 PortID;
/// 8190 the number of a routine that is enabled, a depth under 1, or an identifier of another width.
class CANSYNC_PUBLIC CAN_CFGQ {
 public:
  static constexpr INT kDeepest = 1000;

  INT PortID = 0;            ///< 0
  DWORD MsgID = 0;           ///< with Mask: identifiers of the receive queue
  DWORD Mask = 0;            ///< bits of MsgID that count; 0: every identifier
  BOOL IDE = false;          ///< FALSE 11 bits, TRUE 29; of both queues
  INT RxQueueDepth = 0;      ///< frames, 1..1000
  INT TxQueueDepth = 0;      ///< likewise; those that the daemon has count, too
  INT RxIntOB = 0;           ///< 40..47: routine that is called when a frame came to an empty queue
  WORD RxIntPrm = 0;         ///< what it is told
  BOOL RxEnableInt = false;  ///< it is called
  INT TxIntOB = 0;           ///< 40..47: routine that is called when the last frame was sent
  WORD TxIntPrm = 0;         ///< what it is told
  BOOL TxEnableInt = false;  ///< it is called
  WORD RetVal = 0;           ///< of this call

  /// What RetVal means here; empty: 0000. Not in the manual.
  const std::string& error() const noexcept { return error_; }

  /// `connection` must outlive the block.
  explicit CAN_CFGQ(FrameConnection& connection) : connection_(&connection) {}
  /// Does it once.
  void call();

 private:
  WORD configure();
  WORD refuse(WORD code, std::string reason);

  FrameConnection* connection_;
  std::string error_;
};

}  // namespace cansync::client::function_blocks
