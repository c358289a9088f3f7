#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>

#include "system/descriptor.h"

/// While a line is in run, the computer does not sleep, its power key does nothing, and a shutdown waits until
/// the line is stopped: inhibitor locks of systemd-logind. Source: systemd, "Inhibitor Locks",
/// org.freedesktop.login1(5).
namespace cansyncd {

/// What logind does for a process. One thread.
class Logind {
 public:
  virtual ~Logind() = default;
  Logind() = default;
  Logind(const Logind&) = delete;
  Logind& operator=(const Logind&) = delete;

  /// Takes a lock: it holds until `lock` is closed. `what`: names with colons between, `mode`: "block" or
  /// "delay". Empty: taken; else why not. May take 5 s.
  virtual std::string inhibit(std::string_view what, std::string_view mode, sys::Descriptor& lock) = 0;

  /// Waits; true as soon as the computer begins to shut down.
  virtual bool shuts_down_within(std::chrono::milliseconds time) = 0;
};

/// Over the system's D-Bus, connected when it is first used; null where systemd does not run.
std::unique_ptr<Logind> make_logind();

/// How the locks are.
struct InhibitorState {
  bool held = false;    ///< all that are wanted
  std::string refused;  ///< why one of them could not be taken; empty: none is wanted, or all are held

  friend bool operator==(const InhibitorState&, const InhibitorState&) = default;
};

/// The locks of this process. One thread.
class InhibitorLocks {
 public:
  static constexpr std::chrono::seconds kRetry{30};  ///< after a refusal

  /// `logind` must outlive the object.
  explicit InhibitorLocks(Logind& logind) noexcept : logind_(logind) {}

  /// Takes the locks when the line is in run and gives them back when it is not. A refusal is tried again
  /// later, and changes nothing else.
  InhibitorState step(bool in_run, std::chrono::steady_clock::time_point now);

 private:
  Logind& logind_;
  sys::Descriptor block_;
  sys::Descriptor delay_;
  InhibitorState state_;
  std::chrono::steady_clock::time_point retry_{};
};

/// The thread that speaks to logind: nothing else waits for it, whatever D-Bus does.
class Inhibitors {
 public:
  /// `logind`: null does nothing. `shuts_down` is called on the thread, when the computer begins to shut down
  /// and waits for this process; it must return at once. Throws std::system_error without a thread.
  Inhibitors(std::unique_ptr<Logind> logind, std::function<void()> shuts_down);
  /// Gives the locks back.
  ~Inhibitors();
  Inhibitors(const Inhibitors&) = delete;
  Inhibitors& operator=(const Inhibitors&) = delete;

  /// Whether a line is in run. Any thread; returns at once.
  void set_in_run(bool in_run) noexcept { in_run_.store(in_run, std::memory_order_relaxed); }

  /// As the thread has it. Any thread.
  InhibitorState state() const;

 private:
  void run();

  const std::unique_ptr<Logind> logind_;
  const std::function<void()> shuts_down_;
  std::atomic<bool> in_run_{false};
  std::atomic<bool> stop_{false};
  mutable std::mutex mutex_;
  InhibitorState state_;
  std::thread thread_;
};

}  // namespace cansyncd
