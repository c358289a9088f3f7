#include "sync/system.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include "system/clock.h"

namespace sync_line {
namespace {

template <class T>
T or_errno(T result) noexcept {
  return result < 0 ? static_cast<T>(-errno) : result;
}

class Kernel final : public System {
 public:
  int open(const char* path, int flags) noexcept override {
    return or_errno(::open(path, flags | O_CLOEXEC));
  }
  int control(int descriptor, unsigned long request, void* argument) noexcept override {
    return or_errno(::ioctl(descriptor, request, argument));
  }
  long read(int descriptor, void* buffer, std::size_t size) noexcept override {
    return or_errno(static_cast<long>(::read(descriptor, buffer, size)));
  }
  int set_nonblocking(int descriptor) noexcept override {
    const int flags = ::fcntl(descriptor, F_GETFL);
    return flags < 0 ? -errno : or_errno(::fcntl(descriptor, F_SETFL, flags | O_NONBLOCK));
  }
  void close(int descriptor) noexcept override { ::close(descriptor); }
  Time monotonic() noexcept override { return sys::read_clock(CLOCK_MONOTONIC); }
  Time realtime() noexcept override { return sys::read_clock(CLOCK_REALTIME); }
};

std::string remedy(const std::string& device, int error) {
  switch (error) {
    case ENOENT:
    case ENODEV:
    case ENXIO:
      return "plug the hardware in or load its driver, or name another device";
    case EACCES:
    case EPERM:
      return fmt::format(
          "give the daemon's user the right to read and write it: a udev rule with GROUP=\"cansync\" and "
          "MODE=\"0660\" (`ls -l {}` shows the rights now), and DeviceAllow= in the service unit",
          device);
    case EBUSY:
      return "another program or driver uses it; end that one, or name another line, pin or channel "
             "(`gpioinfo` shows who holds a GPIO line)";
    case ENOTTY:
      return "this is no device of that kind; name another one";
    case EINVAL:
      return "the device has no such line, pin or channel, or cannot do this; name another one";
    case EOPNOTSUPP:
      return "the device or its driver cannot do this; use another one";
    default:
      return "see the kernel's log (`journalctl -k`)";
  }
}

}  // namespace

System& kernel() noexcept {
  static Kernel instance;
  return instance;
}

ClockDifference realtime_minus_monotonic(System& system) noexcept {
  constexpr int kReadings = 3;
  ClockDifference best;
  for (int i = 0; i < kReadings; ++i) {
    const Time before = system.monotonic();
    const Time real = system.realtime();
    const Time width = system.monotonic() - before;
    if (i == 0 || width < best.uncertainty) best = {real - before - width / 2, width};
  }
  return best;
}

std::string reason_and_remedy(const std::string& device, int error) {
  return fmt::format("{}: {}; {}", device, std::generic_category().message(error), remedy(device, error));
}

void open_or_throw(System& system, Descriptor& into, const std::string& option, const std::string& path,
                   int flags) {
  const int opened = system.open(path.c_str(), flags);
  if (opened < 0) throw SetupError(option, reason_and_remedy(path, -opened));
  into.reset(opened);
}

}  // namespace sync_line
