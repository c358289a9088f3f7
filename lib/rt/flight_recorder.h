#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "can/bus.h"
#include "rt/wake_signal.h"

/// A ring of what happened last on a realtime thread, kept for a look back when something went wrong.
namespace rt {

/// One thing that happened. What `value` means depends on the kind.
struct FlightEntry {
  enum class Kind : std::uint8_t {
    wake,        ///< the thread woke: `due` and `at`
    edge,        ///< a SYNC edge was produced: `due` and `at`
    sent,        ///< `frame` was handed to the bus; value: can::SendResult
    received,    ///< `frame` of another node ended at `at`
    echo,        ///< `frame` of this node ended at `at`
    left_out,    ///< nothing was sent in a slot; value: which
    state,       ///< the owner's state changed; value: the new one
    controller,  ///< the controller's state changed; value: can::ControllerState
  };
  Kind kind = Kind::wake;
  std::uint32_t value = 0;
  std::uint64_t interval = 0;
  can::Time at{};   ///< bus clock
  can::Time due{};  ///< bus clock
  can::Frame frame;
};

/// Why a recording was made.
struct FlightTrigger {
  std::uint32_t reason = 0;  ///< the owner's number for it
  std::uint64_t detail = 0;  ///< what belongs to the reason
  std::uint64_t interval = 0;
  can::Time at{};                 ///< bus clock
  can::Time wall_clock_offset{};  ///< wall clock minus bus clock
};

/// The ring, its trigger, and the way to the thread that saves it.
///
/// One realtime thread records; a fault lets it go on for a few intervals, then the ring is frozen and the
/// saving thread is woken. While it is frozen nothing is recorded and further faults are counted. All memory
/// is taken and touched by the constructor.
class FlightRecorder {
 public:
  /// Keeps the newest `entries` (at least 1); recording goes on for `intervals_after` intervals after a
  /// fault. Throws std::system_error without a file descriptor for the signal.
  FlightRecorder(std::size_t entries, std::uint64_t intervals_after);

  // --- the realtime thread: wait-free, no memory; one system call when the ring freezes

  /// Keeps `entry`; the oldest gives way.
  void record(const FlightEntry& entry) noexcept;

  /// Which recording shows a fault.
  enum class Shown : std::uint8_t {
    own,      ///< one of its own
    another,  ///< that of a fault before, which still goes on
    none      ///< none, for the one before is being saved
  };
  /// A fault. The first one leads to a recording, those until it has been saved are counted.
  Shown fault(const FlightTrigger& trigger) noexcept;
  /// True once after a recording could not be saved.
  bool take_not_saved() noexcept {
    return not_saved_.load(std::memory_order_relaxed) &&
           not_saved_.exchange(false, std::memory_order_relaxed);
  }
  /// A fault that is to have no recording of its own.
  void count_fault() noexcept { further_.fetch_add(1, std::memory_order_relaxed); }

  /// An interval begins. `now` stands for the trigger of a recording that was asked for by `request`.
  void begin_interval(const FlightTrigger& now) noexcept;

  /// Nothing more is recorded: a fault for which recording still goes on freezes the ring now. The realtime
  /// thread has ended.
  void finish() noexcept;

  // --- any thread

  /// Asks for a recording; taken up when the next interval begins.
  void request() noexcept { requested_.store(true, std::memory_order_relaxed); }

  // --- the saving thread

  /// Waits until the ring is frozen, `wake_up` was called, or `timeout` has passed. True: it is frozen.
  bool wait_frozen(std::chrono::milliseconds timeout) noexcept;
  /// Makes `wait_frozen` return. Any thread.
  void wake_up() noexcept { signal_.signal(); }
  /// Oldest first. Only while frozen; allocates.
  std::vector<FlightEntry> entries() const;
  /// What froze the ring. Only while frozen.
  const FlightTrigger& trigger() const noexcept { return trigger_; }
  /// Faults and requests that led to no recording since this was last asked.
  std::uint64_t take_further() noexcept { return further_.exchange(0, std::memory_order_relaxed); }
  /// What was frozen could not be saved.
  void not_saved() noexcept { not_saved_.store(true, std::memory_order_relaxed); }
  /// Recording begins again, empty.
  void rearm() noexcept { frozen_.store(false, std::memory_order_release); }

 private:
  bool recording() noexcept;
  void freeze() noexcept;

  std::vector<FlightEntry> ring_;
  const std::uint64_t intervals_after_;
  std::uint64_t count_ = 0;  ///< entries since recording began
  bool pending_ = false;     ///< a fault happened; the ring freezes soon
  bool saved_ = false;       ///< the ring was frozen and holds what is saved already
  std::uint64_t left_ = 0;   ///< intervals until it freezes
  FlightTrigger trigger_;
  std::atomic<bool> frozen_{false};
  std::atomic<bool> requested_{false};
  std::atomic<bool> not_saved_{false};
  std::atomic<std::uint64_t> further_{0};
  WakeSignal signal_;
};

}  // namespace rt
