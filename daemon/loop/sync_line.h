#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "can/bus.h"
#include "daemon_config/daemon_config.h"
#include "sync/gpio.h"
#include "sync/input.h"
#include "sync/phase_lock.h"
#include "sync/phc_output.h"
#include "sync/system.h"

namespace cansyncd {

/// The SYNC line of one daemon: where the edge goes, and what the timeline follows, as [sync] says.
///
/// Constructed and started on the main thread; between `begin` and the end of the realtime thread everything
/// else belongs to that thread, allocates nothing, locks nothing and never waits. System calls per interval:
/// GPIO output 2, GPIO input 1 to 2, PPS one in 16 intervals, hardware clock and software SYNC none.
class SyncLine {
 public:
  /// Takes the devices. `interval`: between two edges. Throws sync_line::SetupError, which names option,
  /// device and remedy. `system` must outlive the line.
  SyncLine(const DaemonConfig& config, can::Time interval, sync_line::System& system);

  /// Starts what runs beside the realtime thread. Throws std::system_error.
  void start();

  /// How the timeline follows an input; empty: it stands by itself.
  const std::optional<sync_line::PhaseLockSettings>& following() const noexcept { return following_; }

  /// The hardware clock, for a test that does its thread's work; null with another output.
  sync_line::PhcOutput* clock() noexcept { return clock_.get(); }

  // --- realtime thread

  /// Learns how the clock of the bus stands to CLOCK_MONOTONIC.
  void begin(can::Bus& bus) noexcept;
  /// Makes the edge, as far as software has a part in it.
  void edge(can::Bus& bus) noexcept;
  /// The edge is a frame on the bus.
  bool makes_frame() const noexcept { return config_.output == SyncOutput::can; }
  /// Whether SYNC is to run; a hardware clock is switched by it.
  void run(bool running) noexcept;
  /// Returns the electrical line to its idle level when it is not there.
  void idle() noexcept;
  /// Takes a frame off the bus when it is a software SYNC of this line; true: it is nothing for the master.
  bool take_frame(const can::ReceivedFrame& received, sync_line::PhaseLock* lock) noexcept;
  /// A software SYNC of another master: the line makes its own under this identifier.
  bool is_others(const can::ReceivedFrame& received) const noexcept;
  /// Hands the edges that the input has seen to the phase lock.
  void follow(sync_line::PhaseLock& lock) noexcept;

  /// Error number of the output: an errno, `kNotSent` when the bus did not take the frame, 0: it works.
  int output_error() const noexcept;
  /// Error number of the input's device; 0: it works.
  int input_error() const noexcept { return input_ ? input_->error() : 0; }
  /// Edges that could not be made, since the start.
  std::uint64_t output_failures() const noexcept { return output_failures_; }

  static constexpr int kNotSent = -1;

 private:
  const SyncConfig config_;
  const std::uint32_t bits_per_second_;
  sync_line::System& system_;
  std::optional<sync_line::PhaseLockSettings> following_;
  std::optional<sync_line::GpioOutput> gpio_;
  std::unique_ptr<sync_line::PhcOutput> clock_;
  std::unique_ptr<sync_line::Input> input_;
  can::Time bus_ahead_{0};  ///< clock of the bus minus CLOCK_MONOTONIC
  bool frame_refused_ = false;
  std::uint64_t output_failures_ = 0;
};

/// Where the SYNC edges that a bus follows come from.
struct SyncSources {
  SyncLine* line = nullptr;          ///< [sync], on a CAN interface; null: it says nothing
  sync_line::Input* wire = nullptr;  ///< the wire of a simulated line, on the clock of the bus; null: none
};

}  // namespace cansyncd
