#include "daemon/service/signal_wait.h"

#include <ctime>

namespace cansyncd {

SignalWait::SignalWait() {
  ::sigemptyset(&set_);
  for (const int number : {SIGTERM, SIGINT, SIGHUP, SIGUSR1}) ::sigaddset(&set_, number);
  ::pthread_sigmask(SIG_BLOCK, &set_, nullptr);
}

std::optional<int> SignalWait::wait(std::optional<std::chrono::microseconds> time) const {
  if (!time) {
    int number = 0;
    while (::sigwait(&set_, &number) != 0) {
    }
    return number;
  }
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(*time);
  const timespec limit = {seconds.count(), std::chrono::nanoseconds(*time - seconds).count()};
  // Also an interrupted wait only means one look too many.
  const int number = ::sigtimedwait(&set_, nullptr, &limit);
  if (number < 0) return std::nullopt;
  return number;
}

}  // namespace cansyncd
