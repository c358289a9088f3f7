#pragma once

#include <pthread.h>

#include <atomic>
#include <cstddef>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "system/descriptor.h"

namespace rt {

/// What a realtime thread asks of the system.
struct RealtimeSettings {
  bool enforce = true;         ///< true: refuse to start without everything below that `Grants` names
  int priority = 60;           ///< SCHED_FIFO, 1..`highest_priority`; 0: normal scheduling
  int cpu = -1;                ///< processor the thread is bound to, from 0; -1: any
  bool lock_memory = true;     ///< mlockall for the whole process, present and future pages
  bool hold_cpu_awake = true;  ///< /dev/cpu_dma_latency at 0 us while the thread lives, when it can be had
  std::size_t prefaulted_stack = std::size_t{256} * 1024;  ///< bytes of stack touched before the work begins
};

/// What the system granted. What was not asked for counts as granted.
struct Grants {
  bool scheduling = false;
  bool affinity = false;
  bool memory_locked = false;
  bool cpu_held_awake = false;
  /// One sentence for each thing that was asked for and not granted, with its remedy.
  std::vector<std::string> missing;
};

/// The system does not grant what was asked for; `what` says what is missing, what was allowed and the
/// remedy.
class RealtimeError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Highest priority a realtime thread may ask for: one below the system's highest, which is left to the
/// kernel's own threads.
int highest_priority() noexcept;

/// A thread prepared for realtime work: scheduling, processor, locked memory, touched stack.
class RealtimeThread {
 public:
  /// Starts the thread, prepares it, and then runs `work` on it once. `work` must not throw.
  /// Throws std::invalid_argument for a priority or processor out of range, RealtimeError when something is
  /// not granted and `enforce` is set (`work` is then never called), std::system_error when no thread can be
  /// created.
  RealtimeThread(const RealtimeSettings& settings, std::function<void()> work);

  /// Waits until `work` has returned, then lets go of the processor's latency. Locked memory stays locked,
  /// because it belongs to the process.
  ~RealtimeThread();
  RealtimeThread(const RealtimeThread&) = delete;
  RealtimeThread& operator=(const RealtimeThread&) = delete;

  /// Waits until `work` has returned; may be called more than once, by one thread.
  void join() noexcept;

  /// What was granted; fixed once the constructor has returned.
  const Grants& grants() const noexcept { return grants_; }

 private:
  enum class Start : int { preparing, prepared, go, give_up };

  static void* entry(void* self) noexcept;
  void prepare() noexcept;
  void lock_memory();
  void hold_cpu_awake();
  void move_to(Start start) noexcept;
  void wait_while(Start start) const noexcept;

  const RealtimeSettings settings_;
  const std::function<void()> work_;
  Grants grants_;
  int scheduling_error_ = 0;  ///< errno values of the thread's own preparation
  int affinity_error_ = 0;
  sys::Descriptor latency_;
  pthread_t thread_{};
  bool joinable_ = false;
  std::atomic<Start> start_{Start::preparing};
};

}  // namespace rt
