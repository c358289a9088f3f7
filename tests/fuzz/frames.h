#pragma once

#include "bytes.h"
#include "can/frame.h"

namespace fuzz {

/// Any frame, also such as no bus carries: 14 bytes of input, the data as it stands on the bus.
inline can::Frame frame(Bytes& in) noexcept {
  can::Frame out;
  const std::uint32_t head = in.number<std::uint32_t>();
  // Bits 0..28 identifier; most frames are standard ones with an identifier of 11 bits. Bit 29: a standard
  // frame whose identifier is too large, or a remote frame of the extended format.
  const std::uint32_t kind = head >> 30;
  const bool wide = (head & 0x20000000u) != 0;
  out.remote = kind == 2;
  out.extended = kind == 1 || (out.remote && wide);
  out.error = kind == 3;
  out.id = kind == 0 && !wide ? head & 0x7FFu : head & 0x1FFFFFFFu;
  out.dlc = in.byte() & 15u;
  for (std::uint8_t& byte : out.data) byte = in.byte();
  return out;
}

}  // namespace fuzz
