#pragma once

#include <cstdint>
#include <optional>

#include "can/bus.h"
#include "can/frame.h"
#include "cansync/numbers.h"
#include "cansync/telegram.h"

namespace sim {

/// A frame that a node wants to put on the bus.
struct Transmission {
  can::Frame frame;
  can::Time not_before{};  ///< when the node has it ready; arbitration decides from then on
};

/// A participant of the simulated bus other than the master. Called on the thread that drives the bus;
/// nothing allocates, blocks or throws after construction.
class Node {
 public:
  virtual ~Node() = default;

  virtual cansync::SlaveNumber number() const noexcept = 0;

  /// Acceptance filter: true when the node wants frames of this identifier (0..0x7FF). Asked once, when it
  /// joins.
  virtual bool accepts(std::uint32_t identifier) const noexcept = 0;

  /// A SYNC edge at `now`.
  virtual void on_sync(can::Time now) noexcept = 0;

  /// A frame the node accepts was on the bus until `end`. `telegram` is the frame decoded, or null when it is
  /// no CANsync telegram. Returns the node's answer, if any.
  virtual std::optional<Transmission> on_frame(const can::Frame& frame, const cansync::Telegram* telegram,
                                               can::Time end) noexcept = 0;
};

}  // namespace sim
