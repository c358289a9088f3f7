#pragma once

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "../cansync_slave/slave_rig.h"
#include "cansync/cluster/cluster.h"
#include "cansync/sim/drive.h"
#include "daemon/cansync/realtime/realtime_loop.h"
#include "daemon/loop/beside_bus.h"
#include "daemon/loop/leading_edges.h"
#include "support/virtual_line.h"

/// Both buses of a cluster as the daemon drives them, in virtual time: a simulated master above, simulated
/// drives below, and the caller in the place of both gateways.
namespace cansyncd::test {

/// What the master above is told.
class AskerAbove final : public cansync::MasterListener {
 public:
  void actual_values(cansync::SlaveNumber, const cansync::ActualValues&) noexcept override {}
  void slave_status(cansync::SlaveNumber, const cansync::SlaveStatus&) noexcept override {}
  void state_changed(cansync::State, cansync::State, cansync::ControlCommand) noexcept override {}
  void parameter_done(cansync::JobId id, const cansync::ParameterResult& result) noexcept override {
    if (id < results.size()) results[id] = result;
  }
  void transfer_progress(cansync::JobId, std::uint32_t) noexcept override {}
  void transfer_done(cansync::JobId, const cansync::TransferResult&) noexcept override {}
  void command_done(cansync::JobId, cansync::Outcome) noexcept override {}
  void event(const cansync::MasterEvent&) noexcept override {}
  std::array<std::optional<cansync::ParameterResult>, 16> results;  ///< by id
};

inline constexpr std::uint16_t kDriveNumber = 100;  ///< CANsync number of drive 0 below

class ClusterRig {
 public:
  explicit ClusterRig(cansync::BitRate bit_rate = cansync::BitRate::mbit1)
      : rate(bit_rate), times(cansync::slot_times(bit_rate)) {
    cluster_settings.upper.number = *cansync::SlaveNumber::from(kNumber);
    cluster_settings.upper.bit_rate = rate;
    cluster_settings.lower = support::line_settings(rate, 2);
    cluster_settings.lower.send_margin = cansync::default_send_margin(rate);
    cluster_settings.gateway.routes = {{{kDriveNumber}, *cansync::SlaveNumber::from(0), {0}},
                                       {{kDriveNumber + 1}, *cansync::SlaveNumber::from(1), {0}}};
    cluster_settings.lead[4] = {.kind = cansync::LeadSource::Kind::reference, .value = 0};
    master_settings.master.bit_rate = rate;
    master_settings.master.send_margin = cansync::default_send_margin(rate);
    master_settings.master.slaves[kNumber].configured = true;
    master_settings.master.process.maximum_slave = *cansync::SlaveNumber::from(kNumber);
    master_settings.master.process.polling.fill(
        {cansync::Cursor::Kind::fixed, *cansync::SlaveNumber::from(kNumber)});
    master_settings.first_edge = times.interval * 5 / 4;
    master_settings.references[0] = {
        .kind = sim::ReferenceCurve::Kind::ramp, .offset = 0x11000000, .step = 1};
    master_settings.references[4] = {.kind = sim::ReferenceCurve::Kind::constant, .offset = 44};
  }

  void build() {
    std::vector<std::unique_ptr<sim::Node>> above;
    auto node = std::make_unique<sim::MasterNode>(master_settings, &asker);
    master = node.get();
    above.push_back(std::move(node));
    upper_line_settings.bits_per_second = lower_line_settings.bits_per_second = times.bits_per_second;
    upper_line_settings.protocol = lower_line_settings.protocol = &sim::drive_faults();
    upper_line_settings.user_number = kNumber;
    if (traced) {
      upper_line_settings.trace = &upper_trace;
      lower_line_settings.trace = &lower_trace;
    }
    upper_line = std::make_unique<sim::Line>(upper_line_settings, std::move(above));
    lower_line =
        std::make_unique<sim::Line>(lower_line_settings, support::drives_for(cluster_settings.lower));
    ASSERT_TRUE(check(cluster_settings).empty());
    cluster = std::make_unique<cansync::Cluster>(cluster_settings);
    upper_bus = make_bus(*upper_line);
    SlaveMachineSettings settings;
    settings.slave = cluster_settings.upper;
    cansync::ParameterDefinition status;
    status.number = settings.status_parameter;
    settings.service.parameters = {status};
    settings.wall_clock = nullptr;
    settings.supervision.interval = times.interval;
    settings.supervision.lock_time = 10 * times.interval;
    settings.supervision.edges_until_fault = 2;
    settings.lock.interval = times.interval;
    settings.lock.greatest_step = times.interval / 1000;
    settings.lock.holdover = 20 * times.interval;
    settings.inputs.wire = upper_line.get();
    settings.cluster = cluster.get();
    settings.edges = &edges;
    machine = std::make_unique<SlaveMachine>(settings, *upper_bus, upper);
    upper_loop = std::make_unique<DeadlineLoop<SlaveMachine>>(*machine, *upper_bus);
    both = std::make_unique<BesideBus<SlaveMachine>>(*lower_line, *upper_loop);
    LoopSettings loop_settings;
    loop_settings.sync_wire = lower_line.get();
    loop_settings.wall_clock = nullptr;
    loop_settings.cluster = cluster.get();
    loop_settings.edges = &edges;
    loop = std::make_unique<RealtimeLoop>(cluster_settings.lower, loop_settings, *both, lower);
  }

  void at(can::Time when, std::function<void()> action) { script_.emplace_back(when, std::move(action)); }
  void at_interval(unsigned interval, std::function<void()> action) {
    at(interval * times.interval, std::move(action));
  }
  /// Builds and runs. Call once.
  void run_until(can::Time end) {
    build();
    for (auto& [when, action] : script_) upper_bus->script.emplace(when, std::move(action));
    upper_bus->script.emplace(end, [this] {
      EXPECT_TRUE(upper.status.read(upper_snapshot));
      EXPECT_TRUE(lower.master.read(lower_snapshot));
      loop->request_stop();
    });
    both->begin();
    loop->run();
    both->end();
    Report report;
    while (lower.reports.try_pop(report)) reports.push_back(report);
    SlaveSideReport told;
    while (upper.reports.try_pop(told)) upper_reports.push_back(told);
    Terminal terminal;
    while (lower.terminals.try_pop(terminal)) terminals.push_back(terminal);
  }
  template <class Kind>
  std::vector<Kind> told() const {
    std::vector<Kind> found;
    for (const Report& report : reports) {
      if (const auto* one = std::get_if<Kind>(&report)) found.push_back(*one);
    }
    return found;
  }
  /// The master above asks for a parameter of a participant below.
  void ask(cansync::JobId id, std::uint16_t sub, std::uint16_t number,
           std::optional<std::uint32_t> value = std::nullopt) {
    cansync::ParameterRequest request;
    request.id = id;
    request.slave = *cansync::SlaveNumber::from(kNumber);
    request.sub_slave = {sub};
    request.number = *cansync::ParameterNumber::from(number);
    request.write = value.has_value();
    request.value = value.value_or(0);
    EXPECT_EQ(master->master().submit(request), cansync::Refusal::none);
  }

  /// The bus above as the loop sees it.
  std::function<std::unique_ptr<WatchedBus>(can::Bus&)> make_bus = [](can::Bus& line) {
    return std::make_unique<WatchedBus>(line);
  };
  bool traced = true;  ///< traces are kept
  cansync::BitRate rate;
  cansync::SlotTimes times;
  cansync::ClusterSettings cluster_settings;
  sim::MasterNodeSettings master_settings;
  sim::LineSettings upper_line_settings;
  sim::LineSettings lower_line_settings;
  LineTrace upper_trace;
  LineTrace lower_trace;
  AskerAbove asker;
  sim::MasterNode* master = nullptr;
  std::unique_ptr<sim::Line> upper_line;
  std::unique_ptr<sim::Line> lower_line;
  LeadingEdges edges;
  std::unique_ptr<cansync::Cluster> cluster;
  SlaveExchange upper{1 << 16};
  Exchange lower{ExchangeSizes{256, 1024, 1 << 12}};
  std::unique_ptr<WatchedBus> upper_bus;
  std::unique_ptr<SlaveMachine> machine;
  std::unique_ptr<DeadlineLoop<SlaveMachine>> upper_loop;
  std::unique_ptr<BesideBus<SlaveMachine>> both;
  std::unique_ptr<RealtimeLoop> loop;
  SlaveSnapshot upper_snapshot;
  MasterSnapshot lower_snapshot;
  std::vector<Report> reports;
  std::vector<SlaveSideReport> upper_reports;
  std::vector<Terminal> terminals;

 private:
  std::vector<std::pair<can::Time, std::function<void()>>> script_;
};

}  // namespace cansyncd::test
