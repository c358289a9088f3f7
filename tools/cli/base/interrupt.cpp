#include "cli/base/interrupt.h"

#include <algorithm>
#include <csignal>
#include <thread>

namespace cansync::cli {
namespace {

using Clock = std::chrono::steady_clock;

std::atomic<bool> pending = false;
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may only use lock-free atomics");

void on_signal(int) {
  pending.store(true);
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
}

const std::atomic<bool>& interrupt_flag() noexcept {
  return pending;
}

bool wait_until(std::chrono::steady_clock::time_point instant) {
  constexpr auto kSlice = std::chrono::milliseconds(20);
  while (!pending.load() && Clock::now() < instant)
    std::this_thread::sleep_until(std::min(instant, Clock::now() + kSlice));
  return pending.load();
}

}  // namespace cansync::cli
