#pragma once

#include <array>
#include <span>
#include <string>

#include "../../frame_connection.h"
#include "../types.h"

namespace cansync::client::function_blocks {

/// SFB 411 CAN_TXQ (Saia 4.2.3): puts a frame into the send queue with each call.
///
/// With Priority it goes in front of the first one whose identifier is higher, second at best. Status: 0000
/// entered; with Error 8185 DLC, 8187 PortID, 8188 no queue was set up, 80A0 no daemon, it is in stop, or
/// MsgID is too large, 80C2 the queue is full: the frame is dropped.
class CANSYNC_PUBLIC CAN_TXQ {
 public:
  INT PortID = 0;                ///< 0
  std::span<const BYTE> TxData;  ///< at least DLC bytes; looked at in the call alone
  DWORD MsgID = 0;               ///< of the width of the queues
  INT DLC = 0;                   ///< 0..8
  BOOL Priority = false;         ///< TRUE: by identifier
  BOOL Error = false;            ///< nothing was entered
  WORD Status = 0;               ///< of this call

  /// What Status means here, or why the frame that failed last was not sent; empty: nothing is wrong. Not in
  /// the manual.
  const std::string& error() const noexcept { return error_; }

  /// `connection` must outlive the block.
  explicit CAN_TXQ(FrameConnection& connection) : connection_(&connection) {}
  /// Enters a frame.
  void call();

 private:
  WORD enter();
  WORD refuse(WORD code, std::string reason);

  FrameConnection* connection_;
  std::string error_;
};

}  // namespace cansync::client::function_blocks
