#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <utility>
#include <variant>
#include <vector>

#include "cansync/settings/timing.h"
#include "cansync/sim/drive_faults.h"
#include "cansync/sim/master_node.h"
#include "cansync/telegram/telegram.h"
#include "daemon/cansync_slave/realtime/slave_machine.h"
#include "daemon/loop/deadline_loop.h"
#include "sim/line.h"
#include "support/timed_bus.h"

/// The slave's realtime loop on a simulated line with a simulated master, in virtual time.
namespace cansyncd::test {

/// Notes every frame with its start, by who sent it.
class LineTrace final : public sim::TraceSink {
 public:
  void frame(const sim::TracedFrame& traced) noexcept override { frames.push_back(traced); }
  void sync(can::Time at) noexcept override { edges.push_back(at); }
  std::vector<sim::TracedFrame> frames;
  std::vector<can::Time> edges;

  /// Starts of the frames of one channel with this slave's number, each after the edge before it.
  std::vector<can::Time> starts(std::uint32_t identifier) const {
    std::vector<can::Time> found;
    for (const sim::TracedFrame& one : frames) {
      if (one.frame.identifier() != identifier || one.frame.error) continue;
      const auto after = std::upper_bound(edges.begin(), edges.end(), one.start);
      found.push_back(after == edges.begin() ? one.start : one.start - *(after - 1));
    }
    return found;
  }
};

/// Does what the test wants at an instant of the bus, and wakes the loop late when it wants that.
class WatchedBus : public test::TimedBus {
 public:
  using TimedBus::TimedBus;

  /// Another node's frame; it is taken before the next one that comes.
  void give(const can::Frame& frame) {
    can::ReceivedFrame received;
    received.frame = frame;
    received.end = behind_.now();
    kept_.push_back(received);
  }

  can::Time late{};  ///< the thread stands still for so long after each wake-up by a frame

  bool receive(can::ReceivedFrame& out) noexcept override {
    if (kept_.empty()) return behind_.receive(out);
    out = kept_.front();
    kept_.erase(kept_.begin());
    return true;
  }

  /// Virtual time goes on only while somebody waits without a frame.
  void stand_still(can::Time until) {
    while (true) {
      can::ReceivedFrame frame;
      while (behind_.receive(frame)) kept_.push_back(frame);
      if (behind_.wait_until(until) != can::Wake::frame) return;
    }
  }

 private:
  void woken(can::Wake wake) noexcept override {
    if (wake == can::Wake::frame && late > can::Time{0}) stand_still(behind_.now() + late);
  }

  std::vector<can::ReceivedFrame> kept_;
};

inline constexpr std::uint8_t kNumber = 5;

/// So many edges stay away.
inline sim::Fault missing_edges(std::uint64_t from, std::uint64_t count) {
  sim::Fault fault;
  fault.kind = sim::FaultKind::missing_sync;
  fault.from = from;
  fault.to = from + count - 1;
  return fault;
}

struct SlaveRig {
  /// `phase`: by which the edges stand after those of the slave's own timeline at first. `supervision`: its
  /// reactions and its limit for reference values count.
  explicit SlaveRig(cansync::BitRate bit_rate = cansync::BitRate::mbit1, std::vector<sim::Fault> faults = {},
                    can::Time phase = {}, const cansync::SlaveSupervisionSettings& supervision = {})
      : rate(bit_rate), times(cansync::slot_times(bit_rate)) {
    sim::MasterNodeSettings settings;
    settings.master.bit_rate = rate;
    settings.master.send_margin = cansync::default_send_margin(rate);
    settings.master.slaves[kNumber].configured = true;
    settings.master.process.maximum_slave = *cansync::SlaveNumber::from(kNumber);
    settings.master.process.polling.fill(
        {cansync::Cursor::Kind::fixed, *cansync::SlaveNumber::from(kNumber)});
    settings.first_edge = times.interval + phase;
    settings.references[0] = {.kind = sim::ReferenceCurve::Kind::ramp, .offset = 100, .step = 1};
    settings.references[4] = {.kind = sim::ReferenceCurve::Kind::constant, .offset = 44};
    auto node = std::make_unique<sim::MasterNode>(settings);
    master = node.get();
    std::vector<std::unique_ptr<sim::Node>> nodes;
    nodes.push_back(std::move(node));
    sim::LineSettings line_settings;
    line_settings.bits_per_second = times.bits_per_second;
    line_settings.protocol = &sim::drive_faults();
    line_settings.user_number = kNumber;
    line_settings.trace = &trace;
    line_settings.faults = std::move(faults);
    line = std::make_unique<sim::Line>(line_settings, std::move(nodes));
    bus = std::make_unique<WatchedBus>(*line);
    SlaveMachineSettings machine_settings;
    machine_settings.slave.number = *cansync::SlaveNumber::from(kNumber);
    machine_settings.slave.bit_rate = rate;
    cansync::ParameterDefinition status;
    status.number = machine_settings.status_parameter;
    machine_settings.service.parameters = {status};
    machine_settings.wall_clock = nullptr;
    machine_settings.supervision = supervision;
    machine_settings.supervision.interval = times.interval;
    machine_settings.supervision.lock_time = 10 * times.interval;
    machine_settings.supervision.edges_until_fault = 2;
    machine_settings.lock.interval = times.interval;
    machine_settings.lock.greatest_step = times.interval / 1000;
    machine_settings.lock.holdover = 20 * times.interval;
    machine_settings.inputs.wire = line.get();
    machine = std::make_unique<SlaveMachine>(machine_settings, *bus, exchange);
    loop = std::make_unique<DeadlineLoop<SlaveMachine>>(*machine, *bus);
  }

  void at(can::Time when, std::function<void()> action) { bus->script.emplace(when, std::move(action)); }
  /// Call once.
  void run_until(can::Time end) {
    at(end, [this] {
      EXPECT_TRUE(exchange.status.read(snapshot));
      loop->request_stop();
    });
    loop->run();
    SlaveSideReport report;
    while (exchange.reports.try_pop(report)) reports.push_back(report);
    ActionReport action;
    while (exchange.actions.try_pop(action)) actions.push_back(action);
  }
  template <class Report>
  std::vector<Report> told() const {
    std::vector<Report> found;
    for (const SlaveSideReport& report : reports) {
      if (const auto* one = std::get_if<Report>(&report)) found.push_back(*one);
    }
    return found;
  }

  cansync::BitRate rate;
  cansync::SlotTimes times;
  LineTrace trace;
  sim::MasterNode* master = nullptr;
  std::unique_ptr<sim::Line> line;
  std::unique_ptr<WatchedBus> bus;
  SlaveExchange exchange{1 << 14};
  std::unique_ptr<SlaveMachine> machine;
  std::unique_ptr<DeadlineLoop<SlaveMachine>> loop;
  SlaveSnapshot snapshot;
  std::vector<SlaveSideReport> reports;
  std::vector<ActionReport> actions;
};

}  // namespace cansyncd::test
