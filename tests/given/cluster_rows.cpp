// What may be given to a cluster of CANsync: a slave of one bus that is the master of another.
#include <chrono>
#include <cstdint>
#include <string>
#include <thread>

#include "cansync/cluster/cluster.h"
#include "cansync/dds/topics.h"
#include "cansync/settings/timing.h"
#include "daemon/cansync/bus/bus_plan.h"
#include "daemon/cansync/exchange.h"
#include "daemon/cansync/gateway/gateway.h"
#include "daemon/cansync/realtime/realtime_loop.h"
#include "daemon/cansync_cluster/segment/cluster_segment.h"
#include "daemon/cansync_slave/segment/slave_segment.h"
#include "daemon/loop/beside_bus.h"
#include "daemon/loop/leading_edges.h"
#include "paced_bus.h"
#include "row_on.h"
#include "rows.h"
#include "support/kept_journal.h"
#include "telegrams.h"

namespace given {
namespace {

struct ClusterParts {
  using File = cansyncd::ClusterFile;
  static File load(const config::Source& source, std::span<const std::string> overrides) {
    return cansyncd::load_cluster_checked(source, overrides);
  }
};

/// Which of its buses a row is on.
enum class Level : std::uint8_t { above, below };

/// Both buses; the other one has a partition and a journal of its own.
class ClusterDaemon : public Daemon {
 public:
  ClusterDaemon(Level level, const std::string& text, const gateway::dds::ParticipantOptions& place,
                cansyncd::JournalSink& journal, std::uint8_t start)
      : Daemon(start),
        level_(level),
        file_(load<ClusterParts>(text)),
        above_participant_(level == Level::above ? place : beside(place)),
        below_participant_(level == Level::below ? place : beside(place)),
        above_line_({.bits_per_second = file_.config.upper.bus.bits_per_second, .transmit_queue = 64},
                    std::move(cansyncd::slave_bus_plan(file_.config.upper).sim.nodes)),
        below_line_({.bits_per_second = file_.config.lower.bus.bits_per_second},
                    std::move(cansyncd::bus_plan(file_.config.lower).sim.nodes)),
        cluster_(file_.config.cluster),
        above_bus_(above_line_),
        above_exchange_(file_.config.upper.realtime.report_queue),
        below_exchange_(cansyncd::ExchangeSizes{}),
        above_gateway_(file_.config.upper, above_exchange_, above_participant_,
                       level == Level::above ? journal : other_journal_, identity),
        below_gateway_(file_.config.lower, below_exchange_, below_participant_,
                       level == Level::below ? journal : other_journal_, identity),
        machine_(above_settings(), above_bus_, above_exchange_),
        above_loop_(machine_, above_bus_, interval()),
        both_(below_line_, above_loop_),
        below_bus_(both_),
        below_loop_(file_.config.lower.master, below_settings(), below_bus_, below_exchange_) {}
  ~ClusterDaemon() override { stop(); }

  void start() override {
    above_gateway_.start();
    below_gateway_.start();
    thread_ = std::thread([this] { cansyncd::ClusterLoop(both_, below_loop_).run(); });
    below_bus_.go_on(std::chrono::milliseconds(1));
  }
  void stop() override {
    if (!thread_.joinable()) return;
    below_loop_.request_stop();
    below_bus_.let_end();
    thread_.join();
    above_gateway_.stop();
    below_gateway_.stop();
  }
  void run(can::Time span) override {
    pass_time(*this, span, [this](can::Time until) { below_bus_.go_on(until); });
  }
  void settle() override {
    given::settle(above_gateway_, above_exchange_);
    given::settle(below_gateway_, below_exchange_);
  }
  void set_read_only(bool /*read_only*/) override { FAIL() << "every change of the file needs a restart"; }
  void reload(const std::string& /*text*/) override { FAIL() << "every change of the file needs a restart"; }
  DisturbedBus& bus() override { return level_ == Level::above ? above_bus_ : below_bus_; }

 private:
  static gateway::dds::ParticipantOptions beside(gateway::dds::ParticipantOptions place) {
    place.partition += ".beside";
    return place;
  }
  can::Time interval() const { return cansync::slot_times(file_.config.lower.master.bit_rate).interval; }
  cansyncd::SlaveMachineSettings above_settings() {
    auto settings = in_virtual_time(
        cansyncd::slave_machine_settings(file_.config.upper, nullptr, {nullptr, &above_line_}));
    settings.cluster = &cluster_;
    settings.edges = &edges_;
    return settings;
  }
  cansyncd::LoopSettings below_settings() {
    cansyncd::LoopSettings settings = in_virtual_time(cansyncd::LoopSettings{});
    settings.sync_wire = &below_line_;
    settings.look_at_every_slot = true;
    settings.cluster = &cluster_;
    settings.edges = &edges_;
    return settings;
  }

  const Level level_;
  cansyncd::KeptJournal other_journal_;
  cansyncd::ClusterFile file_;
  gateway::dds::Participant above_participant_;
  gateway::dds::Participant below_participant_;
  sim::Line above_line_;
  sim::Line below_line_;
  cansync::Cluster cluster_;
  cansyncd::LeadingEdges edges_;
  DisturbedBus above_bus_;
  cansyncd::SlaveExchange above_exchange_;
  cansyncd::Exchange below_exchange_;
  cansyncd::SlaveGateway above_gateway_;
  cansyncd::Gateway below_gateway_;
  cansyncd::SlaveMachine machine_;
  cansyncd::DeadlineLoop<cansyncd::SlaveMachine> above_loop_;
  cansyncd::BesideBus<cansyncd::SlaveMachine> both_;
  PacedBus below_bus_;
  cansyncd::RealtimeLoop below_loop_;
  std::thread thread_;
};

template <Level level>
class ClusterOn final : public ClusterDaemon {
 public:
  template <class... Of>
  explicit ClusterOn(Of&&... of) : ClusterDaemon(level, of...) {}
};

const std::string kCell = R"([bus]
protocol = "cansync-cluster"
bit_rate = 1000000
[dds]
request_max_age_ms = 0
[recorder]
folder = ""
[upper.slave]
number = 5
missing_references = 0
[[upper.sim.job]]
number = 1
parameter = 777
every = 10
[lower.failsafe]
reference_max_age_ms = 0
[lower.startup]
listen_ms = 10
census = false
[lower.sim]
lock_time_ms = 100
[[lower.slave]]
number = 0
[[lower.slave]]
number = 1
)";

/// Reference value 0 below is value 1 above, which the simulated master keeps at 1000.
const std::string kLeadAxis = R"([[lead]]
number = 0
from = "reference"
value = 1
)";

/// In which the master above has activated the slave, and the bus below follows its SYNC.
constexpr std::chrono::milliseconds kSettles{2000};

}  // namespace

void add_cluster_rows(Rows& rows) {
  add_references(rows, "cluster.lead_axis",
                 {make_daemon<ClusterOn<Level::below>>, kCell + kLeadAxis, kSettles});
  add_side_rows(rows, "cluster", {make_daemon<ClusterOn<Level::above>>, kCell, kSettles});
  add_line_rows(rows, "cluster", {make_daemon<ClusterOn<Level::below>>, kCell, kSettles});
}

}  // namespace given
