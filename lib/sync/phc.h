#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "sync/clock_relation.h"
#include "sync/input.h"
#include "sync/system.h"

namespace sync_line {

/// The periodic output of a PTP hardware clock that makes SYNC.
struct PhcPin {
  std::string device = "/dev/ptp0";
  int pin = 0;                ///< programmable pin; -1: the clock's outputs are fixed, nothing is programmed
  std::uint32_t channel = 0;  ///< periodic output channel
  Edge edge = Edge::falling;  ///< the electrical edge that stands for SYNC
};

/// Names of the options that a PhcDevice blames.
struct PhcOptions {
  std::string device = "sync.phc_device";
  std::string pin = "sync.phc_pin";
  std::string channel = "sync.phc_channel";
};

/// A PTP hardware clock with a periodic output. Every function is a system call: not for the realtime thread.
class PhcDevice {
 public:
  /// Opens the clock and programs the pin. Throws SetupError when it cannot be had.
  PhcDevice(System& system, const PhcPin& pin, const PhcOptions& options = {});

  /// Reads the clock beside CLOCK_MONOTONIC, by the best way the driver has: a cross time stamp, a narrow
  /// window, the plain reading. Nothing: `error` says why, or the wall clock was set meanwhile (error 0).
  std::optional<ClockSample> sample() noexcept;

  /// Makes an edge at every hardware time that is a whole multiple of `interval`, from the first one at or
  /// after `from` on. False: the driver refused; `error` says why.
  bool start(Time from, Time interval) noexcept;

  /// Ends the edges.
  bool stop() noexcept;

  /// Error number of the last call; 0: it worked.
  int error() const noexcept { return error_; }

 private:
  enum class Method : std::uint8_t { precise, extended, plain };

  std::optional<ClockSample> read_precise() noexcept;
  std::optional<ClockSample> read_extended() noexcept;
  std::optional<ClockSample> read_plain() noexcept;
  bool request(Time start, Time interval, Time on) noexcept;

  System& system_;
  Descriptor device_;
  const PhcPin pin_;
  Method method_ = Method::extended;
  int error_ = 0;
};

}  // namespace sync_line
