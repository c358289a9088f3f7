#pragma once

#include <string>

#include "../../frame_connection.h"
#include "../types.h"

namespace cansync::client::function_blocks {

/// FC 66 CANRCV (Helmholz 7.2.3): reads one frame that the daemon's filters take, those of high priority
/// first.
///
/// Frames wait in the connection, 400 and 20 of high priority, then the oldest is deleted (STAT bit 2); the
/// bit also says that frames were lost on the way here. Frames of the other width are passed over. RETVAL: 0;
/// 80F1 no daemon is there, or it is in stop; what waits is given all the same.
class CANSYNC_PUBLIC CANRCV {
 public:
  WORD IDHI = 0;      ///< upper 16 bits of the identifier; changes with a frame only, as all down to DW3
  WORD IDLO = 0;      ///< lower 16 bits
  WORD RTRLEN = 0;    ///< bits 0..3 length 0..8, bit 6 RTR, bit 7 it came by the queue of high priority
  WORD DW0 = 0;       ///< data bytes 0 and 1, byte 0 as the high one; 0 where the frame has none
  WORD DW1 = 0;       ///< likewise 2 and 3
  WORD DW2 = 0;       ///< likewise 4 and 5
  WORD DW3 = 0;       ///< likewise 6 and 7
  BOOL Rcvd = false;  ///< TRUE: this call has read a frame; else FALSE

  WORD STAT = 0;   ///< after each call; Helmholz 7.2.5
  INT RETVAL = 0;  ///< of this call

  /// What RETVAL means here; empty: nothing is wrong. Not in the manual.
  const std::string& error() const noexcept { return error_; }

  /// `connection` must outlive the block. `width`: of the project.
  explicit CANRCV(FrameConnection& connection, IdentifierWidth width = IdentifierWidth::bits_11)
      : connection_(&connection), width_(width) {}
  /// One cycle.
  void call();

 private:
  FrameConnection* connection_;
  IdentifierWidth width_;
  std::string error_;
};

}  // namespace cansync::client::function_blocks
