#pragma once

#include <optional>

#include "can/bus.h"
#include "can/frame.h"
#include "sim/node_set.h"

namespace sim {

/// A frame that a node wants to put on the bus.
struct Transmission {
  can::Frame frame;
  can::Time not_before{};  ///< when the node has it ready; arbitration decides from then on
};

/// What a node does at an instant of its own choice.
struct Deed {
  bool sync_edge = false;                    ///< makes the SYNC edge, which all others see
  std::optional<Transmission> transmission;  ///< puts this frame on the bus
};

/// A participant of the simulated bus other than the line's user. Called on the thread that drives the bus;
/// nothing allocates, blocks or throws after construction.
class Node {
 public:
  virtual ~Node() = default;

  /// By which faults and traces name this node. Several nodes may have the same number.
  virtual NodeNumber node_number() const noexcept = 0;

  /// Acceptance filter: true when the node wants frames of this identifier with these flags; length and data
  /// are not looked at. Asked once, when the node joins, for standard data frames; for others each time.
  virtual bool accepts(const can::Frame& frame) const noexcept = 0;

  /// A SYNC edge at `now`.
  virtual void on_sync(can::Time now) noexcept = 0;

  /// A frame the node accepts was on the bus until `end`. Returns the node's answer, if any.
  virtual std::optional<Transmission> on_frame(const can::Frame& frame, can::Time end) noexcept = 0;

  /// True for a node that makes the SYNC edges in the user's place: faults that name nodes do not mean it,
  /// those of the master do. Asked once, when it joins.
  virtual bool is_master() const noexcept { return false; }

  /// When `on_time` is due next. Nothing at the node's joining: never; else at any time again. An instant
  /// that has passed is made up for at once.
  virtual std::optional<can::Time> next_time() const noexcept { return std::nullopt; }

  /// The instant that `next_time` named; `next_time` must name a later one afterwards.
  virtual Deed on_time(can::Time now) noexcept {
    (void)now;
    return {};
  }

  /// The node joins the line at `now`. Returns what it sends first without being asked, if anything.
  virtual std::optional<Transmission> on_join(can::Time now) noexcept {
    (void)now;
    return std::nullopt;
  }

  /// A frame of the node itself was on the bus until `end`. Returns what it sends next without being asked,
  /// if anything.
  virtual std::optional<Transmission> on_sent(const can::Frame& frame, can::Time end) noexcept {
    (void)frame;
    (void)end;
    return std::nullopt;
  }
};

}  // namespace sim
