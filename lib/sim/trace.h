#pragma once

#include <cstdint>

#include "can/bus.h"
#include "can/frame.h"
#include "sim/node_set.h"

namespace sim {

/// Who put a frame on the bus.
struct Sender {
  enum class Kind : std::uint8_t {
    master,
    node,     ///< `node` says which
    foreign,  ///< a fault of kind `inject`
  };
  Kind kind = Kind::master;
  NodeNumber node = 0;
  friend constexpr bool operator==(const Sender&, const Sender&) = default;
};

/// One thing that stood on the bus. An error frame has kind `error`, identifier 0x008 (protocol violation, as
/// SocketCAN numbers it), 8 zero bytes, and the sender whose frame was destroyed.
struct TracedFrame {
  can::Time start{};  ///< instant of the start-of-frame bit; error frame: of the first error flag's first bit
  can::Time end{};    ///< instant at which the last bit was over, interframe space not counted
  can::Frame frame;
  Sender sender;
};

/// Is told everything that happens on a simulated line, in the order of the instants given. Called on the
/// thread that drives the line; in real time that thread is realtime: nothing may allocate, lock, log or
/// block.
class TraceSink {
 public:
  virtual ~TraceSink() = default;
  /// A frame. Told when its transmission begins; an error frame, when it begins.
  virtual void frame(const TracedFrame& frame) noexcept = 0;
  /// A SYNC edge at `at` that at least one node could see.
  virtual void sync(can::Time at) noexcept = 0;
};

}  // namespace sim
