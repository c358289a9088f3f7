#pragma once

#include <array>
#include <cstdint>

#include "can/bus.h"
#include "can/frame.h"

namespace can {

/// Keeps telegrams from piling up in a controller that nobody acknowledges, where they would stand until
/// somebody does, and go out then. Told of every frame that is handed over and of every echo, in the order of
/// the bus; says whether the next may be handed over. Pure; realtime safe; one thread.
///
/// An interval after the first look since a frame was handed over, without any echo, nothing more is handed
/// over: that forgives a late echo, which ends it. After another one nobody acknowledges
/// (`Delivery::unacknowledged`) and the controller is to be reset. When it is known to be empty (all echoes
/// came, it was reset, its interface was down), one frame at a time is handed over until the first echo; the
/// second and later ones of them no sooner than `kPause` after the reset.
///
/// A controller in one-shot mode keeps nothing: frames without an echo are given up after an interval, and
/// the next are handed over, unless its queue was full meanwhile.
class EchoGuard {
 public:
  /// From a reset in vain to the next frame.
  static constexpr Time kPause = std::chrono::seconds(1);

  /// `interval`: of the protocol; 0: guards nothing.
  explicit EchoGuard(Time interval) noexcept : interval_(interval) {}

  /// The time matters to `may_send` now; without it any may be given.
  bool wants_time() const noexcept { return interval_ != Time{0} && resume_ != Time{0}; }
  /// False: leave the frame out.
  bool may_send(Time now) const noexcept;
  /// The controller took a frame. Without a time: reading a clock for each delays those behind it, and after
  /// a standstill would make the frame older than it is. The next look dates it.
  void handed_over(const Frame& frame) noexcept;
  /// The controller had no room for one.
  void queue_full() noexcept { refused_ = true; }

  /// A look for frames begins; what came before `at` is seen by it. `one_shot`: the controller's mode.
  void begin_look(Time at, bool one_shot) noexcept;
  /// The look brought the echo of an own frame.
  void echo(const Frame& frame) noexcept;
  /// The look is over; `everything`: nothing was left behind.
  void end_look(bool everything) noexcept;

  /// Whatever was handed over is gone: the interface was down, the controller was reset or left bus-off.
  void emptied(Time now) noexcept;
  /// Frames were lost on their way here, echoes too: what was handed over counts as sent.
  void echoes_lost() noexcept {
    count_ = 0;
    held_ = false;
  }

  /// True: the controller is to be reset before anything else is handed over.
  bool wants_reset() const noexcept { return held_ && delivery_ != Delivery::normal; }
  /// The reset is not possible: what was handed over stays in the controller.
  void reset_failed() noexcept {
    if (wants_reset()) delivery_ = Delivery::not_emptied;
  }

  Delivery delivery() const noexcept { return delivery_; }
  /// Frames handed over that were never seen on the bus; never falls.
  std::uint64_t unacknowledged() const noexcept { return unacknowledged_; }

 private:
  /// More than are handed over in the two intervals after which nothing more is.
  static constexpr std::size_t kMost = 16;

  const Frame& outstanding(std::size_t i) const noexcept { return frames_[(first_ + i) % kMost]; }
  void forget_first(std::size_t count) noexcept;
  void give_up() noexcept;
  bool silent_for(unsigned intervals) const noexcept;

  const Time interval_;
  std::array<Frame, kMost> frames_ = {};  ///< handed over, no echo yet; oldest at `first_`
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  Time progress_{};  ///< the last echo, or the first look since the oldest of `frames_` was handed over
  Time look_{};
  Time resume_{};          ///< nothing is handed over before
  unsigned given_up_ = 0;  ///< times in a row, one-shot
  bool undated_ = false;   ///< the oldest of `frames_` was handed over since the last look
  bool one_shot_ = false;
  bool proven_ = false;   ///< an echo came since the controller was empty
  bool held_ = false;     ///< nothing is handed over until the controller is empty
  bool refused_ = false;  ///< the queue was full since the last echo
  bool in_vain_ = false;  ///< the last reset brought no echo
  Delivery delivery_ = Delivery::normal;
  std::uint64_t unacknowledged_ = 0;
};

}  // namespace can
