#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>

#include "sync/phase_lock.h"

namespace sync_line {

/// Everything the SYNC line asks of the kernel, so that a test can stand in for it. Every function may be
/// called on the realtime thread; none allocates, locks or throws. Failures come back as -errno.
class System {
 public:
  virtual ~System() = default;

  /// open(2) with `flags` and O_CLOEXEC; a file descriptor.
  virtual int open(const char* path, int flags) noexcept = 0;
  /// ioctl(2).
  virtual int control(int descriptor, unsigned long request, void* argument) noexcept = 0;
  /// read(2): bytes read.
  virtual long read(int descriptor, void* buffer, std::size_t size) noexcept = 0;
  /// Makes reads return -EAGAIN instead of waiting; 0.
  virtual int set_nonblocking(int descriptor) noexcept = 0;
  virtual void close(int descriptor) noexcept = 0;
  /// CLOCK_MONOTONIC.
  virtual Time monotonic() noexcept = 0;
  /// CLOCK_REALTIME.
  virtual Time realtime() noexcept = 0;
};

/// The kernel itself; lives as long as the program.
System& kernel() noexcept;

/// Difference of two clocks, and how far it may be wrong.
struct ClockDifference {
  Time value{0};
  Time uncertainty{0};
};

/// CLOCK_REALTIME minus CLOCK_MONOTONIC, read three times; the narrowest reading counts. No system call where
/// the clocks are read in user space.
ClockDifference realtime_minus_monotonic(System& system) noexcept;

/// A device of the SYNC line cannot be had. `what()` names option, device, reason and remedy.
class SetupError : public std::runtime_error {
 public:
  /// `option`: the configuration option at fault, e.g. "sync.gpio_chip".
  SetupError(const std::string& option, const std::string& text)
      : std::runtime_error(option + ": " + text), option_(option), text_(text) {}
  const std::string& option() const noexcept { return option_; }
  /// `what()` without the option.
  const std::string& text() const noexcept { return text_; }

 private:
  std::string option_;
  std::string text_;
};

/// What an error number of a device means and what mends it. Allocates.
std::string reason_and_remedy(const std::string& device, int error);

/// An open file; closed at the end.
class Descriptor {
 public:
  explicit Descriptor(System& system) noexcept : system_(&system) {}
  ~Descriptor() { reset(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  void reset(int descriptor = -1) noexcept {
    if (descriptor_ >= 0) system_->close(descriptor_);
    descriptor_ = descriptor;
  }
  int get() const noexcept { return descriptor_; }

 private:
  System* system_;
  int descriptor_ = -1;
};

/// Opens `path` or throws SetupError for `option`.
void open_or_throw(System& system, Descriptor& into, const std::string& option, const std::string& path,
                   int flags);

}  // namespace sync_line
