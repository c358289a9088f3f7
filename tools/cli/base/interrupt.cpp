#include "cli/base/interrupt.h"

#include <algorithm>
#include <csignal>
#include <thread>

namespace cansync::cli {
namespace {

using Clock = std::chrono::steady_clock;

std::atomic<bool> pending = false;
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may only use lock-free atomics");

// Of Clock, in its own counts; the program has not been continued: 0.
std::atomic<Clock::rep> continued = 0;
static_assert(std::atomic<Clock::rep>::is_always_lock_free,
              "a signal handler may only use lock-free atomics");

void on_signal(int) {
  pending.store(true);
}

void on_continue(int) {
  continued.store(Clock::now().time_since_epoch().count());
}

}  // namespace

void install_interrupt_handlers() {
  struct sigaction action {};
  action.sa_handler = on_signal;
  // The default comes back after the first signal, so a second one ends the program.
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  action.sa_handler = on_continue;
  action.sa_flags = SA_RESTART;
  sigaction(SIGCONT, &action, nullptr);
}

const std::atomic<bool>& interrupt_flag() noexcept {
  return pending;
}

bool just_continued() noexcept {
  constexpr auto kFoundAgain = std::chrono::seconds(10);
  const auto at = continued.load();
  return at != 0 && Clock::now() < Clock::time_point(Clock::duration(at)) + kFoundAgain;
}

bool wait_until(std::chrono::steady_clock::time_point instant) {
  constexpr auto kSlice = std::chrono::milliseconds(20);
  while (!pending.load() && Clock::now() < instant)
    std::this_thread::sleep_until(std::min(instant, Clock::now() + kSlice));
  return pending.load();
}

}  // namespace cansync::cli
