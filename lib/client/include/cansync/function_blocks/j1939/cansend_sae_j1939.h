#pragma once

#include <string>

#include "../../message_connection.h"
#include "../types.h"

namespace cansync::client::function_blocks {

/// FC 70 CANSEND_SAE_J1939 (Helmholz 7.9.2): sends a frame of 8 bytes.
///
/// The frame waits in the connection, which hands it on with each call of any of its blocks; 400 find room,
/// then the oldest is deleted (STAT bit 6). Source_Addr must be the address that the daemon has claimed: it
/// sends with no other one. RETVAL: 0; 80F1 no daemon, no address, or the daemon was started anew since the
/// last call; 81E1 Source_Addr is not the daemon's; 82E2 another input is out of range. In each case Snd is
/// FALSE, and nothing is sent but with 0.
class CANSYNC_PUBLIC CANSEND_SAE_J1939 {
 public:
  INT Priority = 6;          ///< 0..7
  BOOL DataPageBit = false;  ///< bit 24 of the identifier; bit 25 (R) is sent as 0
  INT PDU_Format = 0;        ///< 0..255
  INT PDU_Specific = 0;      ///< 0..255: destination (below PDU_Format 240; not 254), or group extension
  INT Source_Addr = 0;       ///< 0..253
  BYTE B0 = 0;               ///< data byte 0
  BYTE B1 = 0;               ///< data byte 1
  BYTE B2 = 0;               ///< data byte 2
  BYTE B3 = 0;               ///< data byte 3
  BYTE B4 = 0;               ///< data byte 4
  BYTE B5 = 0;               ///< data byte 5
  BYTE B6 = 0;               ///< data byte 6
  BYTE B7 = 0;               ///< data byte 7
  BOOL Snd = false;          ///< TRUE: send; FALSE after each call

  WORD STAT = 0;   ///< after each call; Helmholz 7.2.5, bits 7 to 4 of sending, of this connection's frames
  INT RETVAL = 0;  ///< of this call

  /// What RETVAL means here, or why the frame that failed last was not sent; empty: nothing is wrong. Not in
  /// the manual.
  const std::string& error() const noexcept { return error_; }
  /// Frames that were taken and not sent, as far as the daemon said so. Not in the manual.
  UDINT failures() const noexcept;

  /// `connection` must outlive the block.
  explicit CANSEND_SAE_J1939(MessageConnection& connection) : connection_(&connection) {}
  /// One cycle.
  void call();

 private:
  INT send();
  INT refuse(INT code, std::string reason);

  MessageConnection* connection_;
  std::string error_;
};

}  // namespace cansync::client::function_blocks
