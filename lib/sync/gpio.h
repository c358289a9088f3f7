#pragma once

#include <linux/gpio.h>

#include <array>
#include <cstdint>
#include <string>

#include "sync/input.h"
#include "sync/system.h"

namespace sync_line {

/// One line of a GPIO chip.
struct GpioLine {
  std::string chip = "/dev/gpiochip0";  ///< character device
  std::uint32_t line = 0;               ///< offset on that chip
  Edge edge = Edge::falling;            ///< the electrical edge that stands for SYNC
};

/// SYNC on an output line of a GPIO chip (character device, version 2 of its interface).
///
/// The line idles at the level the SYNC edge leaves, high for `Edge::falling`. Two system calls per interval.
/// Constructed on any thread, used by the realtime thread.
class GpioOutput {
 public:
  /// Takes the line. Throws SetupError for `option` when it cannot be had.
  GpioOutput(System& system, const GpioLine& line, const std::string& chip_option,
             const std::string& line_option);

  /// Makes the SYNC edge. False: the kernel refused; `error` says why. Realtime safe.
  bool pulse() noexcept { return set(true); }
  /// Returns the line to its idle level, when it is not there. Realtime safe.
  bool idle() noexcept { return !active_ || set(false); }

  /// Error number of the last call; 0: it worked.
  int error() const noexcept { return error_; }

 private:
  bool set(bool active) noexcept;

  System& system_;
  Descriptor line_;
  bool active_ = false;
  int error_ = 0;
};

/// Edges on an input line of a GPIO chip, with the kernel's time stamps.
class GpioInput final : public Input {
 public:
  /// Takes the line. Throws SetupError for `option` when it cannot be had.
  GpioInput(System& system, const GpioLine& line, const std::string& chip_option,
            const std::string& line_option);

  /// One system call for up to 16 edges.
  bool take(Time near, Time& at) noexcept override;
  int error() const noexcept override { return error_; }

 private:
  static constexpr std::size_t kEvents = 16;

  System& system_;
  Descriptor line_;
  std::array<gpio_v2_line_event, kEvents> events_ = {};
  std::size_t count_ = 0;
  std::size_t taken_ = 0;
  bool drained_ = false;  ///< the last read came back with room to spare
  int error_ = 0;
};

}  // namespace sync_line
