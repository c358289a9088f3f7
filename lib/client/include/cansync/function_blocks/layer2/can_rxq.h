#pragma once

#include <span>

#include "../../frame_connection.h"
#include "../types.h"

namespace cansync::client::function_blocks {

/// SFB 410 CAN_RXQ (Saia 4.2.3): takes one frame out of the receive queue.
///
/// Status: 0000, NDR says whether there was one; 80C2 with NDR and Error there was one, and others came to
/// the full queue, or were lost on the way here, since the last call; with Error alone 8186 RxData has not 8
/// bytes, 8187 PortID, 8188 no queue was set up, 80A0 no daemon is there.
class CANSYNC_PUBLIC CAN_RXQ {
 public:
  INT PortID = 0;          ///< 0
  std::span<BYTE> RxData;  ///< 8 bytes at least, of which DLC are written
  DWORD MsgID = 0;         ///< of the frame; changes with one only, as DLC
  INT DLC = 0;             ///< 0..8
  BOOL NDR = false;        ///< a frame was copied
  BOOL Error = false;      ///< Status is not 0000
  WORD Status = 0;         ///< of this call

  /// `connection` must outlive the block.
  explicit CAN_RXQ(FrameConnection& connection) : connection_(&connection) {}
  /// One cycle.
  void call();

 private:
  WORD take();

  FrameConnection* connection_;
};

}  // namespace cansync::client::function_blocks
