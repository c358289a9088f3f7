#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "cansync/settings/settings.h"
#include "cansync/settings/timing.h"
#include "cansync/sim/drive.h"
#include "cansync/sim/drive_faults.h"
#include "daemon/cansync/exchange.h"
#include "daemon/cansync/realtime/realtime_loop.h"
#include "sim/line.h"

namespace cansyncd::support {

/// Master settings for slaves 0..count-1 at a bit rate.
inline cansync::MasterSettings line_settings(cansync::BitRate rate, unsigned count = cansync::kSlaves) {
  cansync::MasterSettings settings;
  settings.bit_rate = rate;
  settings.process.maximum_slave = *cansync::SlaveNumber::from(count - 1);
  settings.startup.census = false;  // which_drive_test has this switched on
  for (unsigned i = 0; i < count; ++i) settings.slaves[i].configured = true;
  return settings;
}

/// Simulated drives for every configured slave; `change` may alter each one's settings.
inline std::vector<std::unique_ptr<sim::Node>> drives_for(
    const cansync::MasterSettings& settings, const std::function<void(sim::DriveSettings&)>& change = {}) {
  std::vector<std::unique_ptr<sim::Node>> drives;
  for (unsigned i = 0; i < cansync::kSlaves; ++i) {
    if (!settings.slaves[i].configured) continue;
    sim::DriveSettings drive;
    drive.slave.number = *cansync::SlaveNumber::from(i);
    drive.slave.bit_rate = settings.bit_rate;
    drive.lock_time = std::chrono::milliseconds(100);
    drive.memory.size = 128 * 1024;
    if (change) change(drive);
    drives.push_back(std::make_unique<sim::Drive>(drive));
  }
  return drives;
}

/// The daemon's realtime loop on a simulated line, in virtual time on the caller's thread: as in the daemon
/// but for DDS, with the caller in the place of the gateway.
class VirtualLine : private sim::TraceSink {
 public:
  VirtualLine(const cansync::MasterSettings& settings, std::vector<std::unique_ptr<sim::Node>> nodes,
              const std::vector<sim::Fault>& faults = {})
      : times_(cansync::slot_times(settings.bit_rate)),
        line_(bus_settings(faults), std::move(nodes)),
        exchange_(ExchangeSizes{}),
        loop_(settings, loop_settings(), line_, exchange_) {}

  /// Called at each SYNC edge with the number of edges before it; may push requests.
  std::function<void(std::uint64_t)> on_edge = [](std::uint64_t) {};
  /// Called when a frame begins, with the time since the last SYNC edge.
  std::function<void(const sim::TracedFrame&, can::Time)> on_frame = [](const sim::TracedFrame&, can::Time) {
  };

  /// Runs until `edges` SYNC edges were made. Call once.
  void run(std::uint64_t edges) {
    last_ = edges;
    loop_.run();
  }

  /// Makes `run` return earlier. Any thread.
  void stop() noexcept { loop_.request_stop(); }

  Exchange& exchange() { return exchange_; }
  sim::Line& line() { return line_; }
  sim::Drive& drive(std::size_t index) { return dynamic_cast<sim::Drive&>(line_.node(index)); }
  MasterSnapshot snapshot() {
    MasterSnapshot latest;
    static_cast<void>(exchange_.master.read(latest));
    return latest;
  }

  /// Both reference telegrams with all values, released once.
  void give_references(std::uint32_t value) {
    for (const auto channel : {cansync::Channel::one, cansync::Channel::two}) {
      cansync::ReferenceUpdate update;
      update.channel = channel;
      update.value = {value, value, value, value};
      update.valid_mask = 0x0F;
      static_cast<void>(exchange_.requests.try_push(update));
    }
  }

 private:
  sim::LineSettings bus_settings(const std::vector<sim::Fault>& faults) {
    sim::LineSettings settings;
    settings.bits_per_second = times_.bits_per_second;
    settings.faults = faults;
    settings.protocol = &sim::drive_faults();
    settings.trace = this;
    return settings;
  }
  LoopSettings loop_settings() {
    LoopSettings settings;
    settings.sync_wire = &line_;
    settings.wall_clock = nullptr;
    return settings;
  }

  void frame(const sim::TracedFrame& traced) noexcept override { on_frame(traced, traced.start - edge_); }
  void sync(can::Time at) noexcept override {
    edge_ = at;
    on_edge(edges_++);
    if (edges_ >= last_) loop_.request_stop();
  }

  const cansync::SlotTimes& times_;
  sim::Line line_;
  Exchange exchange_;
  RealtimeLoop loop_;
  can::Time edge_{};
  std::uint64_t edges_ = 0;
  std::uint64_t last_ = 0;
};

}  // namespace cansyncd::support
