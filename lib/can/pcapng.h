#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "can/frame.h"

/// Capture files in the pcapng format (draft-ietf-opsawg-pcapng), which Wireshark and its relatives read.
/// Pure functions over bytes; they allocate, so not for the realtime thread.
namespace can {

/// Link type of a CAN frame behind SocketCAN's pseudo header (LINKTYPE_CAN_SOCKETCAN).
inline constexpr std::uint16_t kLinkTypeSocketcan = 227;

/// Makes the bytes of one capture, block by block, little endian: a section header, an interface description
/// before the first frame of each interface, and an enhanced packet block a frame. Time stamps have a
/// resolution of 1 ns. Keeps the name of each interface it has seen, nothing else.
class PcapngWriter {
 public:
  /// The section header, the first bytes of the file. `application`: program and version, UTF-8.
  static std::string begin(std::string_view application);

  /// The blocks of the next frame. `time` since 1970 (UTC), negative ones count as 0; `interface` as in
  /// `if_name`; a data length over 8 counts as 8. The flags stand in the pseudo header. Every packet has 16
  /// bytes, as the kernel's own captures, so that none is taken for CAN FD.
  std::string frame(std::chrono::nanoseconds time, std::string_view interface, const Frame& frame);

 private:
  std::map<std::string, std::uint32_t, std::less<>> interfaces_;
};

}  // namespace can
