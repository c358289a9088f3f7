#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace layer2 {

/// What the status bytes of a CAN 300 PRO say (Helmholz 5).
struct StatusFacts {
  bool running = false;  ///< the module runs, its parameters were read
  bool bus_off = false;
  bool stopped = false;  ///< the controller is not on the bus: stopped, or its interface missing or down
  bool receive_overrun = false;       ///< frames were lost before anybody could take them
  std::uint16_t transmit_errors = 0;  ///< error counters, as the controller has them; over 255 counts as 255
  std::uint16_t receive_errors = 0;   ///< likewise, for receiving; over 255 counts as 255
  /// One direction, high and normal queue.
  struct Queues {
    bool high_half_full = false;
    bool normal_half_full = false;
    bool overflowed = false;  ///< either of them, since the last reset
    bool empty = true;        ///< both
  };
  Queues send;
  Queues receive;
  std::uint8_t node = 0xFF;  ///< of the node filter, 1..127; 0xFF: there is none
};

/// The error register EFLG, status byte 1 (Helmholz 5.2). Warning from a counter of 96 on, passive from 128.
std::uint8_t error_register(const StatusFacts& facts) noexcept;

/// Status byte 2, the low byte of STAT (Helmholz 5.3): bits 7 to 4 of sending, 3 to 0 of receiving; each half
/// full (high), overflow, half full (normal), empty.
std::uint8_t queue_byte(const StatusFacts& facts) noexcept;

/// The 16 bytes of the status image (Helmholz 5). Those of the CANopen master and the internal ones are 0.
std::array<std::uint8_t, 16> status_image(const StatusFacts& facts) noexcept;

/// Why the LED BF would be lit (Helmholz 3.5): an error counter is not 0, the state of the controller is not
/// good, or a queue overflowed. Of several the gravest.
enum class BusFault : std::uint8_t {
  off,       ///< it is dark
  bus_off,   ///< the controller has left the bus
  stopped,   ///< the controller is not on the bus
  passive,   ///< an error counter is 128 or more
  errors,    ///< an error counter is not 0
  overflow,  ///< frames had no room in a queue or in the controller
};
/// Pure; realtime safe.
BusFault bus_fault(const StatusFacts& facts) noexcept;

/// As it stands in `FrameStatus`: "off", "bus-off", "stopped", "passive", "errors", "overflow".
std::string_view name_of(BusFault fault) noexcept;

/// The word STAT of the function blocks (Helmholz 7.2.5): status byte 0 as the high byte, whose bit 14 is
/// always set, and status byte 2.
std::uint16_t status_word(const StatusFacts& facts) noexcept;

}  // namespace layer2
