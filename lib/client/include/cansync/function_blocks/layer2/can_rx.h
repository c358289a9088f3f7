#pragma once

#include <span>
#include <string>

#include "../../frame_connection.h"
#include "../types.h"

namespace cansync::client::function_blocks {

/// SFB 400 CAN_RX (Saia 4.2.2): opens a message object for a frame, and gives the frame.
///
/// Status: 0000 with NDR there is one; 8180 none yet; 80C2 with NDR and Error there is one, and another came
/// while the object was full; with Error alone 8186 ObjID, 8187 PortID, 8190 RxData is shorter than the
/// frame, which waits, 80A0 no daemon, or it is in stop, 80C0 the object is not set up for receiving.
class CANSYNC_PUBLIC CAN_RX {
 public:
  INT ObjID = 0;           ///< 0..31
  INT PortID = 0;          ///< 0
  std::span<BYTE> RxData;  ///< as long as the frame at least; DLC bytes are written
  BOOL ReleaseRx =
      false;           ///< opens a closed object; in a call with NDR it is open for the next frame at once
  BOOL RTR = false;    ///< with ReleaseRx: a remote frame is sent, in each call that opens
  BOOL NDR = false;    ///< a frame was copied
  BOOL Error = false;  ///< Status says why
  DWORD MsgID = 0;     ///< of the frame; changes with one only, as DLC
  INT DLC = 0;         ///< 0..8
  WORD Status = 0;     ///< of this call

  /// What Status means here; empty: nothing is wrong. Not in the manual.
  const std::string& error() const noexcept { return error_; }

  /// `connection` must outlive the block.
  explicit CAN_RX(FrameConnection& connection) : connection_(&connection) {}
  /// One cycle.
  void call();

 private:
  WORD take();
  WORD refuse(WORD code, std::string reason);

  FrameConnection* connection_;
  std::string error_;
};

}  // namespace cansync::client::function_blocks
