#pragma once

#include <cstdint>
#include <initializer_list>
#include <vector>

#include "can/frame.h"

namespace can::test {

/// A standard data frame; `extended`, `remote` and `error` make other ones of it.
inline Frame data_frame(std::uint32_t id, const std::vector<std::uint8_t>& data) {
  Frame frame{.id = id};
  for (const std::uint8_t byte : data) frame.data[frame.dlc++] = byte;
  return frame;
}

inline Frame extended(Frame frame) {
  frame.extended = true;
  return frame;
}
/// Keeps the length and has no data.
inline Frame remote(Frame frame) {
  frame.remote = true;
  frame.data = {};
  return frame;
}
inline Frame error(Frame frame) {
  frame.error = true;
  return frame;
}

/// Data and remote frames with 11 and 29 bits; an identifier under 0x800 does not make a frame a standard
/// one.
inline std::vector<Frame> four_kinds() {
  const Frame plain = data_frame(0x123, {1, 2, 3});
  return {plain,
          remote(plain),
          extended(plain),
          extended(remote(plain)),
          extended(data_frame(0x18DAF110, {0xFF})),
          extended(remote(data_frame(0x18DAF110, {})))};
}

}  // namespace can::test
