#pragma once

#include <string>

#include "../../frame_connection.h"
#include "../types.h"

namespace cansync::client::function_blocks {

/// FC 65 CANSEND (Helmholz 7.2.2): sends a frame.
///
/// The frame waits in the connection, which hands it on with each call of any of its blocks; 400 find room,
/// and 20 of high priority, then the oldest is deleted (STAT bit 6). RETVAL: 0; 80F1 no daemon, it is in
/// stop, or it was started anew since the last call; 82E2 identifier or length out of range.
class CANSYNC_PUBLIC CANSEND {
 public:
  WORD IDHI = 0;     ///< upper 16 bits of the identifier
  WORD IDLO = 0;     ///< lower 16 bits; 11 bits: 0..16#7FF
  WORD RTRLEN = 0;   ///< bits 0..3 length 0..8, bit 6 RTR, bit 7 high priority; others are not looked at
  WORD DW0 = 0;      ///< data bytes 0 and 1: byte 0 is the high one, as in the module's host
  WORD DW1 = 0;      ///< likewise 2 and 3
  WORD DW2 = 0;      ///< likewise 4 and 5
  WORD DW3 = 0;      ///< likewise 6 and 7; of a remote frame no data are looked at
  BOOL Snd = false;  ///< TRUE: send; FALSE when the frame was taken, that is with RETVAL 0

  WORD STAT = 0;   ///< after each call; Helmholz 7.2.5
  INT RETVAL = 0;  ///< of this call

  /// What RETVAL means here, or why the frame that failed last was not sent; empty: nothing is wrong. Not in
  /// the manual.
  const std::string& error() const noexcept { return error_; }
  /// Frames that were taken and not sent, as far as the daemon said so. Not in the manual.
  UDINT failures() const noexcept;

  /// `connection` must outlive the block. `width`: of the project.
  explicit CANSEND(FrameConnection& connection, IdentifierWidth width = IdentifierWidth::bits_11)
      : connection_(&connection), width_(width) {}
  /// One cycle.
  void call();

 private:
  INT send();
  INT refuse(INT code, std::string reason);

  FrameConnection* connection_;
  IdentifierWidth width_;
  std::string error_;
};

}  // namespace cansync::client::function_blocks
