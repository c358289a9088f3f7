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
  not_delivered,   ///< held back: nobody acknowledges what was handed over before
};

/// Why `wait_until` came back.
enum class Wake : std::uint8_t { deadline, frame, interrupted };

/// Controller state after CAN 2.0, fault confinement.
enum class ControllerState : std::uint8_t { error_active, error_warning, error_passive, bus_off, stopped };

/// State of the interface behind a bus.
enum class LinkState : std::uint8_t {
  up,
  down,            ///< there, but not set up
  missing,         ///< no such interface now
  wrong_adapter,   ///< another adapter than the configured one has this name: nothing is sent or received
  wrong_bit_rate,  ///< set up with another bit rate than the configured one: nothing is sent
  not_one_shot,    ///< not in one-shot mode, which the configuration demands: nothing is sent
  listen_only,     ///< in listen-only mode: its controller neither sends nor acknowledges
};

/// What becomes of the frames that are handed to the controller, as their echoes tell.
enum class Delivery : std::uint8_t {
  normal,          ///< they are on the bus, or none was handed over
  unacknowledged,  ///< none of them; nothing more is handed over before the controller has been emptied
  not_emptied,     ///< likewise, and the controller cannot be reset: they go out when somebody acknowledges
};

/// Where the time of a received frame comes from.
enum class TimestampSource : std::uint8_t {
  simulation,  ///< exact, by the simulated bus
  hardware,    ///< the controller's own clock
  kernel,      ///< the kernel, when the driver handed the frame over
  thread,      ///< the realtime thread, when it looked: no better than its wake-ups
};

/// State and counters of the controller behind a bus. Counters count since the start and never fall.
struct ControllerStatus {
  ControllerState state = ControllerState::error_active;
  std::uint16_t transmit_errors = 0;  ///< transmit error counter, 0..256
  std::uint16_t receive_errors = 0;   ///< receive error counter, 0..255
  std::uint64_t overruns = 0;         ///< frames lost because the controller had no room for them
  LinkState link = LinkState::up;
  std::uint32_t bits_per_second = 0;     ///< bit rate the interface is set to; 0: not known
  std::uint64_t error_frames = 0;        ///< error frames of every kind
  std::uint64_t acknowledge_errors = 0;  ///< frames that nobody acknowledged
  std::uint64_t restarts = 0;            ///< times the controller left bus-off
  std::uint64_t queue_full = 0;          ///< telegrams refused because the send queue was full
  std::uint64_t dropped = 0;             ///< received frames lost because nobody had taken them in time
  Delivery delivery = Delivery::normal;
  std::uint64_t unacknowledged = 0;  ///< frames handed over that were never on the bus

  /// Received frames that nobody got, whoever had no room for them.
  std::uint64_t lost_frames() const noexcept { return overruns + dropped; }

  friend bool operator==(const ControllerStatus&, const ControllerStatus&) = default;
};

/// What became of a request to reset the controller.
enum class ResetResult : std::uint8_t {
  done,           ///< the controller starts anew
  pending,        ///< begun; `reset_result` tells when it is done
  not_permitted,  ///< the daemon has not got the right (CAP_NET_ADMIN)
  unavailable,    ///< the interface is missing or down, or its driver cannot
};

/// What the realtime loop needs of a bus: a clock, a way to sleep, and frames in and out.
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

  /// As `wait_until`, also on a bus that is set up to sleep on when frames come: for a caller that can go on
  /// only with the next frame.
  virtual Wake wait_for_frame(Time deadline) noexcept { return wait_until(deadline); }

  /// Takes the oldest received frame (echoes included). Returns false when there is none; never blocks.
  virtual bool receive(ReceivedFrame& out) noexcept = 0;

  /// Hands a frame to the controller for transmission as soon as the bus is free.
  virtual SendResult send(const Frame& frame) noexcept = 0;

  /// State of the controller.
  virtual ControllerStatus status() noexcept = 0;

  /// Resets the controller, which leaves bus-off. `pending`: ask `reset_result` from time to time; a second
  /// reset before that one has ended is the same one.
  virtual ResetResult reset() noexcept = 0;

  /// What became of the last `reset`.
  virtual ResetResult reset_result() noexcept = 0;

  /// Where the times of received frames come from, as of the newest one.
  virtual TimestampSource timestamp_source() noexcept = 0;
};

}  // namespace can
