#pragma once

#include <cstdint>

#include "../../frame_connection.h"
#include "../types.h"

namespace cansync::client::function_blocks {

/// SFB 404 CAN_STAT (Saia 4.2.1): the state of the controller, as the daemon told it last, on every change
/// and once a second. RetVal: 0000; 8187 PortID; 80A0 (not in the manual's list) no daemon is there: the
/// outputs are those of before.
class CANSYNC_PUBLIC CAN_STAT {
 public:
  INT PortID = 0;  ///< 0

  BYTE RxErrCtr = 0;        ///< error counter of receiving; over 255 counts as 255
  BYTE TxErrCtr = 0;        ///< of sending, likewise
  BOOL BusOff = false;      ///< the controller is bus-off
  BOOL Error = false;       ///< error frames, or frames that nobody acknowledged, came since the last call
  BOOL Warning = false;     ///< a counter is 96 or more
  BOOL ErrorState = false;  ///< FALSE error active, TRUE error passive
  WORD RetVal = 0;          ///< of this call

  /// `connection` must outlive the block.
  explicit CAN_STAT(FrameConnection& connection) : connection_(&connection) {}
  /// One cycle.
  void call();

 private:
  FrameConnection* connection_;
  std::uint64_t errors_ = 0;
  bool looked_ = false;
};

}  // namespace cansync::client::function_blocks
