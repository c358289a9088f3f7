#include "rt/wake_signal.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <system_error>

namespace rt {

WakeSignal::WakeSignal() : descriptor_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  if (!descriptor_.is_open()) {
    throw std::system_error(errno, std::generic_category(), "no event descriptor (raise LimitNOFILE=)");
  }
}

void WakeSignal::signal() noexcept {
  // A pending signal is enough: its taker looks at the data after `clear`, and so sees what was written
  // before this.
  if (pending_.exchange(true, std::memory_order_acq_rel)) return;
  const std::uint64_t one = 1;
  // It can fail only when the counter is at its limit, and then a signal is pending anyway.
  [[maybe_unused]] const auto written = ::write(descriptor(), &one, sizeof one);
}

bool WakeSignal::wait(std::chrono::milliseconds timeout) noexcept {
  pollfd poll_descriptor{descriptor(), POLLIN, 0};
  if (::poll(&poll_descriptor, 1, static_cast<int>(timeout.count())) <= 0) return false;
  clear();
  return true;
}

void WakeSignal::clear() noexcept {
  std::uint64_t count = 0;
  // It fails when nothing is pending, which is just as well.
  [[maybe_unused]] const auto taken = ::read(descriptor(), &count, sizeof count);
  // Only now: a signal between the two lines is then swallowed before its data is looked at, never after.
  pending_.exchange(false, std::memory_order_acq_rel);
}

}  // namespace rt
