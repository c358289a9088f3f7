#pragma once

#include <string>

#include "../../message_connection.h"
#include "../types.h"

namespace cansync::client::function_blocks {

/// FC 71 CANRCV_SAE_J1939 (Helmholz 7.9.3): reads one frame that the daemon's [[receive]] sections take.
///
/// Frames wait in the connection, 400 of them, then the oldest is deleted (STAT bit 2); the bit also says
/// that frames were lost on the way here. Messages in packets do not come here. RETVAL: 0; 80F1 no daemon is
/// there, or it neither has an address nor only listens; what waits is given all the same.
class CANSYNC_PUBLIC CANRCV_SAE_J1939 {
 public:
  INT Priority = 0;          ///< 0..7; changes with a frame only, as all down to B7
  BOOL DataPageBit = false;  ///< bit 24 of the identifier
  INT PDU_Format = 0;        ///< 0..255
  INT PDU_Specific = 0;      ///< 0..255: destination (below PDU_Format 240), or group extension
  INT Source_Addr = 0;       ///< 0..254
  BYTE B0 = 0;               ///< bytes that the frame does not have are 16#FF, "not available"
  BYTE B1 = 0;               ///< data byte 1
  BYTE B2 = 0;               ///< data byte 2
  BYTE B3 = 0;               ///< data byte 3
  BYTE B4 = 0;               ///< data byte 4
  BYTE B5 = 0;               ///< data byte 5
  BYTE B6 = 0;               ///< data byte 6
  BYTE B7 = 0;               ///< data byte 7
  BOOL Recd = false;         ///< TRUE: this call has read a frame; else FALSE

  WORD STAT = 0;   ///< after each call; Helmholz 7.2.5
  INT RETVAL = 0;  ///< of this call

  /// What RETVAL means here; empty: nothing is wrong. Not in the manual.
  const std::string& error() const noexcept { return error_; }
  /// Bytes that the frame has, 0..8. Not in the manual.
  INT length() const noexcept { return length_; }

  /// `connection` must outlive the block.
  explicit CANRCV_SAE_J1939(MessageConnection& connection) : connection_(&connection) {}
  /// One cycle.
  void call();

 private:
  MessageConnection* connection_;
  INT length_ = 0;
  std::string error_;
};

}  // namespace cansync::client::function_blocks
