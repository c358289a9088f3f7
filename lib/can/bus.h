#pragma once

#include <chrono>
#include <cstdint>

#include "can/frame.h"

namespace can {

/// Time of a bus's own clock: nanoseconds since that clock's arbitrary start. It never goes back.
using Time = std::chrono::nanoseconds;

/// A frame as the bus delivered it.
struct ReceivedFrame {
  Frame frame;
  Time end{};        ///< instant at which the frame's last bit stood on the bus
  bool own = false;  ///< true: the echo of a frame sent through this very object
};

/// What became of a frame handed to the bus.
enum class SendResult : std::uint8_t {
  queued,          ///< handed to the controller; the echo tells when it was on the bus
  queue_full,      ///< leave this telegram out; never retry in the same slot
  bus_off,         ///< the controller takes no part in the bus; reset it
  interface_down,  ///< the interface is missing or not up
};

/// Why `wait_until` came back.
enum class Wake : std::uint8_t { deadline, frame, interrupted };

/// Controller state after CAN 2.0, fault confinement.
enum class ControllerState : std::uint8_t { error_active, error_warning, error_passive, bus_off, stopped };

/// State and counters of the controller behind a bus.
struct ControllerStatus {
  ControllerState state = ControllerState::error_active;
  std::uint16_t transmit_errors = 0;  ///< transmit error counter, 0..256
  std::uint16_t receive_errors = 0;   ///< receive error counter, 0..255
  std::uint64_t overruns = 0;         ///< frames lost for want of room since the start

  friend bool operator==(const ControllerStatus&, const ControllerStatus&) = default;
};

/// What the realtime loop needs of a bus: a clock, a way to sleep, frames in and out, and the SYNC edge.
///
/// All functions are called by one thread, the realtime thread; none allocates, locks, logs or throws.
/// Implementations: the simulated line in virtual and in real time (`lib/sim`), SocketCAN.
class Bus {
 public:
  virtual ~Bus() = default;

  /// The bus clock now.
  virtual Time now() noexcept = 0;

  /// Sleeps until `deadline`, or until a frame can be received, whichever comes first. A deadline in the past
  /// returns `Wake::deadline` at once.
  virtual Wake wait_until(Time deadline) noexcept = 0;

  /// Takes the oldest received frame (echoes included). Returns false when there is none; never blocks.
  virtual bool receive(ReceivedFrame& out) noexcept = 0;

  /// Hands a frame to the controller for transmission as soon as the bus is free.
  virtual SendResult send(const Frame& frame) noexcept = 0;

  /// Produces the SYNC edge that stands for `due`; called as close after `due` as the thread wakes.
  virtual void sync_edge(Time due) noexcept = 0;

  /// State of the controller.
  virtual ControllerStatus status() noexcept = 0;

  /// Resets the controller, which leaves bus-off. False: this bus cannot or may not.
  virtual bool reset() noexcept = 0;
};

}  // namespace can
