#include "dds/signal.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <cstdint>

#include "dds/entity.h"

namespace gateway::dds {

DataSignal::DataSignal() : fd_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  if (fd_ < 0) {
    throw SetupError(
        "no file descriptor is left for the DDS wake-up; raise the limit (LimitNOFILE=, ulimit -n)");
  }
}

DataSignal::~DataSignal() {
  close(fd_);
}

void DataSignal::raise() noexcept {
  const std::uint64_t one = 1;
  // Fails only when the counter is full, and then it is raised anyway.
  [[maybe_unused]] const ssize_t written = ::write(fd_, &one, sizeof one);
}

void DataSignal::clear() noexcept {
  std::uint64_t count = 0;
  [[maybe_unused]] const ssize_t read_bytes = ::read(fd_, &count, sizeof count);
}

bool DataSignal::wait(int milliseconds) noexcept {
  pollfd entry{fd_, POLLIN, 0};
  return poll(&entry, 1, milliseconds) > 0;
}

}  // namespace gateway::dds
