#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "can/bus.h"
#include "can/frame.h"

namespace sim {

/// The bits of `frame` that arbitrate, as a number: the lower one wins. Standard wins over extended with the
/// same base identifier, a data frame over a remote frame.
std::uint32_t arbitration_key(const can::Frame& frame) noexcept;

/// A frame that waits for the bus.
struct PendingFrame {
  can::Frame frame;
  can::Time ready{};        ///< takes part in arbitration from this instant on
  std::uint64_t order = 0;  ///< order of hand-over; decides between equal identifiers
  std::uint32_t key = 0;    ///< `arbitration_key`
  std::uint32_t bits = 0;   ///< length on the bus with interframe space
  std::uint8_t sender = 0;  ///< participant; meaning is the caller's
  bool repeated = false;    ///< was on the bus once already and is sent again by a fault
};

/// True when `a` goes before `b`, both being ready.
constexpr bool wins(const PendingFrame& a, const PendingFrame& b) noexcept {
  return a.key != b.key ? a.key < b.key : a.order < b.order;
}

/// Frames of several senders that wait for the bus. Room for `capacity` frames is taken at construction;
/// nothing else allocates. Realtime safe.
class PendingFrames {
 public:
  explicit PendingFrames(std::size_t capacity) : capacity_(capacity) { frames_.reserve(capacity); }

  /// Adds a frame; false when there is no room.
  bool push(const PendingFrame& frame) noexcept;

  /// The first instant at which a frame is ready; nothing when none waits.
  std::optional<can::Time> earliest() const noexcept;

  /// The frame that wins the arbitration at `start`; null when none is ready then. Valid until the next
  /// change.
  const PendingFrame* winner(can::Time start) const noexcept;

  /// Takes `frame` out, which `winner` has returned.
  void remove(const PendingFrame& frame) noexcept;

  /// Number of frames of a sender.
  unsigned count(std::uint8_t sender) const noexcept;

  /// Drops all frames of a sender.
  void drop(std::uint8_t sender) noexcept;

 private:
  std::size_t capacity_;
  std::vector<PendingFrame> frames_;
};

/// The transmit queue of one controller: frames leave in the order they came, whatever their identifiers.
/// Room for `depth` frames is taken at construction. Realtime safe.
class TransmitQueue {
 public:
  explicit TransmitQueue(std::size_t depth) : frames_(depth) {}

  std::size_t size() const noexcept { return size_; }
  /// The frame that is sent next; null when empty.
  const PendingFrame* front() const noexcept { return size_ == 0 ? nullptr : &frames_[first_]; }
  /// Adds at the end; the queue must not be full.
  void push(const PendingFrame& frame) noexcept;
  /// Makes `frame` the first again: its transmission failed. The queue must not be full.
  void push_front(const PendingFrame& frame) noexcept;
  /// Takes the first one out; the queue must not be empty.
  void pop() noexcept;
  void clear() noexcept { first_ = size_ = 0; }

 private:
  std::vector<PendingFrame> frames_;
  std::size_t first_ = 0;
  std::size_t size_ = 0;
};

}  // namespace sim
