#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "../../export.h"
#include "../types.h"

/// Tables of SFB 402 and SFB 413 as data blocks for FrameConnection::load_data_block. Pure; any thread.
namespace cansync::client::function_blocks {

/// A message object in the table of SFB 402 (Saia 4.2.2).
struct CanObjCfgDef {
  INT ObjID = 0;            ///< 0..31
  DWORD MsgID = 0;          ///< 0..16#7FF; IDE: 0..16#1FFFFFFF
  DWORD Mask = 0xFFFFFFFF;  ///< receives: bits of MsgID that count
  BOOL IDE = false;         ///< FALSE 11 bits, TRUE 29
  BOOL Dir = false;         ///< FALSE receives, TRUE sends
  BOOL EnableInt = false;   ///< the routine of SFB 403 is called for each frame
  DINT Timeout = 0;         ///< ms until a job to send is aborted, 0..3600000; 0: never
};

/// An entry in the table of SFB 413 (Saia 4.2.4).
struct CanIOEntry {
  DWORD MsgID = 0;    ///< of the telegram
  INT MsgOffset = 0;  ///< first byte in it, 0..7
  INT VA = 0;         ///< first byte in the process image of its direction, 0..1023
  INT Size = 1;       ///< bytes, 1..8; MsgOffset and Size are at most 8 together
  BOOL IO = false;    ///< FALSE received, TRUE sent
};

/// The data block with a table of message objects.
CANSYNC_PUBLIC std::vector<std::uint8_t> data_block(std::span<const CanObjCfgDef> table);
/// The data block with a table of a data mapping.
CANSYNC_PUBLIC std::vector<std::uint8_t> data_block(std::span<const CanIOEntry> table);

}  // namespace cansync::client::function_blocks
