#include <cansync/function_blocks/layer2/data_blocks.h>

#include "client/src/function_blocks/layer2/block_table.h"

namespace cansync::client::function_blocks {
namespace {

void put(std::vector<std::uint8_t>& bytes, std::uint32_t value, unsigned size) {
  while (size > 0) bytes.push_back(static_cast<std::uint8_t>(value >> 8 * --size));
}

/// DBVersion, and three words that are reserved.
std::vector<std::uint8_t> header() {
  return std::vector<std::uint8_t>(BlockTable::kHeader, 0);
}

}  // namespace

std::vector<std::uint8_t> data_block(std::span<const CanObjCfgDef> table) {
  auto bytes = header();
  for (const CanObjCfgDef& entry : table) {
    put(bytes, static_cast<std::uint16_t>(entry.ObjID), 2);
    put(bytes, entry.MsgID, 4);
    put(bytes, entry.Mask, 4);
    put(bytes, (entry.IDE ? 1u : 0u) | (entry.Dir ? 2u : 0u) | (entry.EnableInt ? 4u : 0u), 1);
    put(bytes, 0, 1);
    put(bytes, static_cast<std::uint32_t>(entry.Timeout), 4);
  }
  return bytes;
}

std::vector<std::uint8_t> data_block(std::span<const CanIOEntry> table) {
  auto bytes = header();
  for (const CanIOEntry& entry : table) {
    put(bytes, entry.MsgID, 4);
    for (const INT word : {entry.MsgOffset, entry.VA, entry.Size})
      put(bytes, static_cast<std::uint16_t>(word), 2);
    put(bytes, entry.IO ? 1 : 0, 1);
    put(bytes, 0, 1);
  }
  return bytes;
}

}  // namespace cansync::client::function_blocks
