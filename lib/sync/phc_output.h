#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>

#include "rt/latest_value.h"
#include "sync/clock_relation.h"
#include "sync/input.h"
#include "sync/phc.h"

namespace sync_line {

/// SYNC made in hardware by a PTP hardware clock, and the clock's edges as an input for the timeline.
///
/// The edges stand at whole multiples of the interval on the hardware clock, so that all clocks that PTP
/// keeps together make them together. A thread of its own (normal priority) reads the clock ten times a
/// second, switches the output, and hands the relation of the clocks to the realtime thread, which makes no
/// system call for it. When the hardware clock is set, the output is started again on the new time.
class PhcOutput final : public Input {
 public:
  /// Distance of two readings of the clock.
  static constexpr Time kPeriod = std::chrono::milliseconds(100);
  /// A relation older than this is not used; the timeline then holds over.
  static constexpr Time kFresh = std::chrono::seconds(2);

  /// Takes the clock. Throws SetupError.
  PhcOutput(System& system, const PhcPin& pin, Time interval, const PhcOptions& options = {});
  /// Ends the thread and the output.
  ~PhcOutput() override;
  PhcOutput(const PhcOutput&) = delete;
  PhcOutput& operator=(const PhcOutput&) = delete;

  /// Starts the thread. Throws std::system_error.
  void start_thread();

  /// One reading, and the switching that is due. The thread does nothing else; a test calls it instead.
  void step() noexcept;

  // --- realtime thread

  /// Whether edges are to be made; takes effect with the thread's next step.
  void want(bool on) noexcept { wanted_.store(on, std::memory_order_relaxed); }

  /// The hardware's edge nearest to `near`, each edge once.
  bool take(Time near, Time& at) noexcept override;

  /// Error number of the last step that failed since one worked; 0: it works.
  int error() const noexcept override { return error_.load(std::memory_order_relaxed); }

  /// How often the hardware clock was set since the start.
  std::uint64_t clock_steps() const noexcept { return clock_steps_.load(std::memory_order_relaxed); }

 private:
  void run() noexcept;
  void switch_output(bool on) noexcept;

  const Time interval_;
  PhcDevice device_;
  ClockRelation relation_;
  std::optional<bool> running_;    ///< the hardware makes edges; nothing: that could not be switched yet
  std::uint64_t steps_known_ = 0;  ///< clock steps the running output was started after

  std::atomic<bool> wanted_{false};
  std::atomic<int> error_{0};
  std::atomic<std::uint64_t> clock_steps_{0};
  rt::LatestValue<ClockLine> line_;

  // Realtime thread's own.
  ClockLine known_;
  bool any_ = false;
  Time last_{0};

  std::mutex mutex_;
  std::condition_variable stop_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace sync_line
