#pragma once

#include <span>
#include <string>

#include "../../frame_connection.h"
#include "../types.h"

namespace cansync::client::function_blocks {

/// SFB 401 CAN_TX (Saia 4.2.2): gives a message object a job to send, and tells how far it is.
///
/// Status: 0000 with Done the job has ended, without Done there is none; 8181 in execution; 8182 aborted;
/// with Error 8185 DLC, 8186 ObjID or MsgID, 8187 PortID, 8190 TxData is shorter than DLC, 80A0 no daemon, it
/// is in stop, or the frame was not seen on the bus, 80C0 the object is not set up for sending, 80C2 it has a
/// job, which goes on, 80C4 Timeout. An end is told in one call.
class CANSYNC_PUBLIC CAN_TX {
 public:
  INT ObjID = 0;                 ///< 0..31
  INT PortID = 0;                ///< 0
  DWORD MsgID = 0;               ///< in place of the object's, of its width
  INT DLC = 0;                   ///< 0..8
  std::span<const BYTE> TxData;  ///< at least DLC bytes; looked at in the call alone
  BOOL MultipleTx = false;       ///< with RTR: each remote frame is answered; FALSE: one
  BOOL RTR = false;              ///< the frame is sent as the answer to a remote frame of MsgID
  BOOL Act = false;              ///< a rising edge gives the job
  BOOL Abort = false;            ///< ends the job; nothing else is done
  BOOL Done = false;             ///< the frame stood on the bus; of a call with a rising edge the job before
  BOOL Error = false;            ///< Status says why
  WORD Status = 0;               ///< of this call

  /// What Status means here; empty: nothing is wrong. Not in the manual.
  const std::string& error() const noexcept { return error_; }

  /// `connection` must outlive the block.
  explicit CAN_TX(FrameConnection& connection) : connection_(&connection) {}
  /// One cycle.
  void call();

 private:
  WORD look(BOOL rose);
  WORD start();
  WORD refuse(WORD code, std::string reason);

  FrameConnection* connection_;
  BOOL acted_ = false;
  std::string error_;
};

}  // namespace cansync::client::function_blocks
