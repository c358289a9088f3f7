// Clusters in virtual time: a master, a gateway, 32 slaves of which one is a gateway, and 32 slaves, each
// line with frames to the bit, on one core. docs/performance.md has the figures and the command.
#include <benchmark/benchmark.h>

#include <chrono>
#include <cstdlib>
#include <memory>
#include <vector>

#include "cansync/sim/cluster_node.h"
#include "cansync/sim/drive.h"
#include "cansync/sim/drive_faults.h"
#include "cansync/sim/master_node.h"
#include "sim/line.h"

namespace {

using namespace cansync;

constexpr unsigned kFirstGateway = 0;     // on the top line
constexpr unsigned kSecondGateway = 31;   // on the middle line
constexpr unsigned kLowestNumber = 1000;  // CANsync number of slave 0 of the lowest line

struct NobodyThere final : SlaveServiceListener {
  void asked(const AskedParameter&) noexcept override {}
  void dropped(std::uint64_t) noexcept override {}
  void answered(std::uint64_t) noexcept override {}
  void block_begun(const AskedBlock&) noexcept override {}
  void block_complete(std::uint64_t) noexcept override {}
  void step_asked(std::uint64_t, const AskedStep&) noexcept override {}
  void block_ended(std::uint64_t, BlockEnd) noexcept override {}
  void control_word(std::uint16_t) noexcept override {}
  void action(std::uint8_t, std::uint8_t, std::uint16_t) noexcept override {}
  void sync_activated() noexcept override {}
};

struct CountedJobs final : MasterListener {
  void actual_values(SlaveNumber, const cansync::ActualValues&) noexcept override {}
  void slave_status(SlaveNumber, const SlaveStatus&) noexcept override {}
  void state_changed(State, State, ControlCommand) noexcept override {}
  void parameter_done(JobId, const ParameterResult& result) noexcept override {
    if (result.outcome == Outcome::done) ++done;
  }
  void transfer_progress(JobId, std::uint32_t) noexcept override {}
  void transfer_done(JobId, const TransferResult&) noexcept override {}
  void command_done(JobId, Outcome) noexcept override {}
  void event(const MasterEvent&) noexcept override {}
  std::uint64_t done = 0;
};

MasterSettings master_of(BitRate rate, unsigned slaves) {
  MasterSettings settings;
  settings.bit_rate = rate;
  settings.send_margin = default_send_margin(rate);
  settings.process.maximum_slave = *SlaveNumber::from(slaves - 1);
  for (unsigned i = 0; i < slaves; ++i) settings.slaves[i].configured = true;
  return settings;
}

sim::ClusterNodeSettings gateway_of(BitRate rate, unsigned number) {
  sim::ClusterNodeSettings settings;
  settings.cluster.upper.number = *SlaveNumber::from(number);
  settings.cluster.upper.bit_rate = rate;
  settings.cluster.lower = master_of(rate, kSlaves);
  settings.delay = slot_times(rate).bit_time() * 20;
  ParameterDefinition status;
  status.number = settings.status_parameter;
  settings.service.parameters = {status};
  for (const std::uint8_t value : {std::uint8_t{0}, std::uint8_t{4}})
    settings.cluster.lead[value] = {LeadSource::Kind::reference, value, {}, true};
  return settings;
}

std::unique_ptr<sim::Node> drive_of(BitRate rate, unsigned number) {
  sim::DriveSettings settings;
  settings.slave.number = *SlaveNumber::from(number);
  settings.slave.bit_rate = rate;
  settings.lock_time = std::chrono::milliseconds(100);
  return std::make_unique<sim::Drive>(settings);
}

/// The three lines.
struct ThreeLevels {
  explicit ThreeLevels(BitRate rate) {
    sim::MasterNodeSettings master;
    master.master = master_of(rate, kFirstGateway + 1);
    master.references[0] = {sim::ReferenceCurve::Kind::ramp, 0, 50};
    master.references[4] = {sim::ReferenceCurve::Kind::ramp, 0, 50};
    sim::ClusterNodeSettings first = gateway_of(rate, kFirstGateway);
    sim::ClusterNodeSettings second = gateway_of(rate, kSecondGateway);
    for (unsigned n = 0; n < kSlaves; ++n) {
      const SubSlave number{static_cast<std::uint16_t>(kLowestNumber + n)};
      first.cluster.gateway.routes.push_back({number, *SlaveNumber::from(kSecondGateway), number});
      second.cluster.gateway.routes.push_back({number, *SlaveNumber::from(n), {}});
    }
    std::vector<std::unique_ptr<sim::Node>> high, mid, low;
    for (unsigned n = 0; n < kSlaves; ++n) low.push_back(drive_of(rate, n));
    for (unsigned n = 0; n < kSecondGateway; ++n) mid.push_back(drive_of(rate, n));
    auto lower_gateway = std::make_unique<sim::ClusterNode>(second, nobody, lower_jobs);
    auto upper_gateway = std::make_unique<sim::ClusterNode>(first, nobody, lower_jobs);
    auto top_master = std::make_unique<sim::MasterNode>(master, &jobs);
    gateways = {upper_gateway.get(), lower_gateway.get()};
    node = top_master.get();
    mid.push_back(std::move(lower_gateway));
    high.push_back(std::move(top_master));
    high.push_back(std::move(upper_gateway));
    sim::LineSettings settings;
    settings.bits_per_second = slot_times(rate).bits_per_second;
    settings.protocol = &sim::drive_faults();
    lowest = std::make_unique<sim::Line>(settings, std::move(low));
    middle = std::make_unique<sim::Line>(settings, std::move(mid));
    settings.user_number = 30;
    top = std::make_unique<sim::Line>(settings, std::move(high));
    gateways[0]->connect(*middle);
    gateways[1]->connect(*lowest);
    levels = std::make_unique<sim::LevelRun>(*top, gateways);
  }
  bool active() {
    for (sim::ClusterNode* gateway : gateways) {
      if (gateway->cluster().state() != ClusterState::active) return false;
    }
    return is_active(node->master().state());
  }
  /// A parameter of the lowest line is asked for all the time.
  void ask() {
    if (node->master().open_parameter_jobs() != 0) return;
    ParameterRequest request;
    request.id = ++ids;
    request.slave = *SlaveNumber::from(kFirstGateway);
    request.sub_slave = {static_cast<std::uint16_t>(kLowestNumber + ids % kSlaves)};
    request.number = *ParameterNumber::from(301);
    static_cast<void>(node->master().submit(request));
  }

  NobodyThere nobody;
  CountedJobs jobs, lower_jobs;
  JobId ids = 0;
  sim::MasterNode* node = nullptr;
  std::vector<sim::ClusterNode*> gateways;
  std::unique_ptr<sim::Line> lowest, middle, top;
  std::unique_ptr<sim::LevelRun> levels;
};

/// "times_real_time" is bus time over CPU time, all levels active, with both reference and both actual value
/// telegrams on every line in every interval, and a parameter on its way through both gateways all the time.
void three_levels(benchmark::State& state) {
  constexpr int kIntervals = 10'000;
  const auto rate = static_cast<BitRate>(state.range(0));
  const SlotTimes& times = slot_times(rate);
  std::uint64_t frames = 0, done = 0;
  for (auto _ : state) {
    state.PauseTiming();
    ThreeLevels net(rate);
    for (int i = 0; i < 20'000 && !net.active(); ++i) net.levels->run_to(net.levels->now() + times.interval);
    if (!net.active()) std::abort();
    const std::uint64_t before =
        net.top->counters().frames + net.middle->counters().frames + net.lowest->counters().frames;
    state.ResumeTiming();
    for (int i = 0; i < kIntervals; ++i) {
      net.ask();
      net.levels->run_to(net.levels->now() + times.interval);
    }
    frames +=
        net.top->counters().frames + net.middle->counters().frames + net.lowest->counters().frames - before;
    done += net.jobs.done;
  }
  const double intervals = static_cast<double>(state.iterations()) * kIntervals;
  const double bus_seconds = intervals * std::chrono::duration<double>(times.interval).count();
  state.counters["times_real_time"] = benchmark::Counter(bus_seconds, benchmark::Counter::kIsRate);
  state.counters["frames_per_interval"] = static_cast<double>(frames) / intervals;
  state.counters["jobs_per_interval"] = static_cast<double>(done) / intervals;
  state.SetLabel(std::to_string(times.bits_per_second / 1000) + " kbit/s, 1 + 32 + 32 slaves");
}
BENCHMARK(three_levels)->Arg(3)->Arg(2)->Arg(1)->Arg(0)->Unit(benchmark::kMillisecond);

}  // namespace
