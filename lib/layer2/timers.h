#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "can/frame.h"

namespace layer2 {

/// An instant on the clock of the bus: nanoseconds since its arbitrary start.
using Time = std::chrono::nanoseconds;

/// One timer.
struct TimerSettings {
  can::Frame frame;                              ///< what it sends
  Time period = std::chrono::milliseconds(100);  ///< between two frames, over 0
  Time phase{0};                                 ///< from its start to the first frame
  bool cyclic = true;                            ///< false: it sends one frame and stops

  friend bool operator==(const TimerSettings&, const TimerSettings&) = default;
};

/// What it takes of the bus, as `can::share_of_bus`; one that is not cyclic: nothing. Pure; realtime safe.
std::int64_t share_of_bus(const TimerSettings& timer, std::uint32_t bits_per_second) noexcept;

/// The 16 timers of a module, each of which sends a frame (Helmholz 3.3, 6.3.5).
///
/// Frames stand on a grid from the instant a timer was started at: start + phase + n * period. What went by
/// while nobody looked, or while its frame before still waited, is left out and counted, never made up for,
/// so that a timer neither drifts nor bursts. Realtime safe; one thread.
class Timers {
 public:
  static constexpr unsigned kMost = 16;

  /// Gives a timer (1..kMost) what it sends and when. One that runs goes on in its grid when the period and
  /// the phase stay, and is stopped otherwise. False, and nothing has changed: no such timer, or a period
  /// that is not over 0, or a phase under 0.
  bool configure(unsigned number, const TimerSettings& settings) noexcept;
  /// Stops a timer, which is configured no longer; its counters stay. False: there is no such timer.
  bool forget(unsigned number) noexcept;
  /// Changes what a configured timer sends from its next frame on. False: it is not configured.
  bool set_frame(unsigned number, const can::Frame& frame) noexcept;

  /// Starts a timer anew. False: it is not configured.
  bool start(unsigned number, Time now) noexcept;
  /// False: there is no such timer. One that does not run is stopped, too.
  bool stop(unsigned number) noexcept;
  /// Stops every timer.
  void stop_all() noexcept;

  /// It was given what it sends.
  bool configured(unsigned number) const noexcept;
  /// It was started, and has not ended.
  bool running(unsigned number) const noexcept;
  /// Of a configured timer.
  const TimerSettings& settings(unsigned number) const noexcept { return timers_[number - 1].settings; }
  /// What all that are configured but `number` take of the bus, as `can::share_of_bus`.
  std::int64_t share_of_others(unsigned number, std::uint32_t bits_per_second) const noexcept;
  /// Frames of a timer that were handed over, and those left out, since the start; of 1..kMost.
  std::uint64_t sent(unsigned number) const noexcept { return timers_[number - 1].sent; }
  /// Frames of a timer (1..kMost) that were left out, since the start.
  std::uint64_t left_out(unsigned number) const noexcept { return timers_[number - 1].left_out; }

  /// It is `now`: frames become due.
  void advance(Time now) noexcept;
  /// When `advance` must be called at the latest; Time::max(): no timer runs.
  Time next_deadline() const noexcept;
  /// The timer whose frame is due longest, the lowest number of several; nothing: none is.
  std::optional<unsigned> due() const noexcept;
  /// The frame of a timer that was due was handed over.
  void taken(unsigned number) noexcept;

 private:
  struct Timer {
    TimerSettings settings;
    bool configured = false;
    bool running = false;
    bool due = false;
    Time due_since{0};
    Time next{0};  ///< of a running one
    std::uint64_t sent = 0;
    std::uint64_t left_out = 0;
  };

  std::array<Timer, kMost> timers_ = {};
};

/// The synchronous window (Helmholz 6.3.7): in each `repeat` the frames of clients are sent between `begin`
/// and `end` alone.
struct WindowSettings {
  bool used = false;
  Time repeat = std::chrono::milliseconds(10);
  Time begin{0};
  Time end = std::chrono::milliseconds(10);
  bool holds_high = true;  ///< frames of the high priority queue, too

  friend bool operator==(const WindowSettings&, const WindowSettings&) = default;
};

/// What can be wrong with a window.
enum class WindowProblem : std::uint8_t {
  none,
  repeat_not_over_zero,
  end_not_after_begin,
  end_after_repeat,
};

/// Pure; realtime safe.
WindowProblem check(const WindowSettings& settings) noexcept;

/// Says when the window is open. It runs from the start of timer 1 on when timer 2 was started directly after
/// it; without both, frames are sent at any time. Realtime safe; one thread.
class SyncWindow {
 public:
  /// It does not run before its timers are started.
  explicit SyncWindow(const WindowSettings& settings) noexcept : settings_(settings) {}

  /// A timer was started, or stopped; any, in the order in which it happened.
  void timer_started(unsigned number, Time now) noexcept;
  /// A timer was stopped.
  void timer_stopped(unsigned number) noexcept;

  /// Timers 1 and 2 belong to the window, and send nothing.
  bool used() const noexcept { return settings_.used; }
  /// Frames of high priority are held, too.
  bool holds_high() const noexcept { return settings_.holds_high; }
  /// Both timers run; without, frames are sent at any time.
  bool runs() const noexcept { return settings_.used && running_; }
  /// A frame that takes `length` on the bus may be sent now: it ends within the window.
  bool open(Time now, Time length) const noexcept;
  /// The next instant at which the window opens; Time::max() when it does not run.
  Time next_opening(Time now) const noexcept;

 private:
  WindowSettings settings_;
  std::optional<Time> begun_;  ///< timer 1 was the last that was started, then
  Time start_{0};
  bool running_ = false;
};

}  // namespace layer2
