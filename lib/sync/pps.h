#pragma once

#include <cstdint>
#include <string>

#include "sync/input.h"
#include "sync/system.h"

namespace sync_line {

/// A pulse-per-second source of the kernel.
struct PpsSource {
  std::string device = "/dev/pps0";
  Edge edge = Edge::rising;  ///< rising: the driver's "assert" edge; falling: its "clear" edge
};

/// The pulses of /dev/ppsN: one edge a second. Its time stamps are on CLOCK_REALTIME and are carried over to
/// CLOCK_MONOTONIC when they are read; a pulse during which the wall clock was set shows as an outlier.
class PpsInput final : public Input {
 public:
  /// Intervals between two looks: a pulse is a second apart, and every look is a system call.
  static constexpr unsigned kLookEvery = 16;

  /// Throws SetupError for `option` when the source cannot be had or cannot capture that edge.
  PpsInput(System& system, const PpsSource& source, const std::string& option);

  bool take(Time near, Time& at) noexcept override;
  int error() const noexcept override { return error_; }

 private:
  System& system_;
  Descriptor device_;
  const bool assert_;
  bool seen_any_ = false;
  std::uint32_t sequence_ = 0;
  unsigned turn_ = 0;
  int error_ = 0;
};

}  // namespace sync_line
