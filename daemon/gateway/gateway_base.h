#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "can/bus.h"
#include "can/link_facts.h"
#include "daemon/bus/bus_obstacle.h"
#include "daemon/desk/audit.h"
#include "daemon/desk/event_text.h"
#include "daemon/desk/gateway_events.h"
#include "daemon/desk/gateway_thread.h"
#include "daemon/desk/second_daemon.h"
#include "daemon/gateway/gateway_network.h"
#include "daemon/gateway/loss_row.h"
#include "daemon/service/daemon_identity.h"
#include "daemon/service/journal.h"
#include "daemon/service/new_configuration.h"
#include "daemon/service/pending_restart.h"
#include "daemon/service/service.h"
#include "daemon/service/surroundings.h"
#include "daemon/status/bus_events.h"
#include "daemon/status/common_status.h"
#include "daemon/status/metrics_desk.h"
#include "daemon/status/status_line.h"
#include "dds/participant.h"
#include "dds/signal.h"

namespace cansyncd {

/// What the gateways of all protocols have and do alike. A gateway binds the exchange with the realtime
/// thread of a bus to the DDS topics: one thread of normal priority that sleeps until the realtime thread or
/// DDS has something, and the only one that touches DDS.
///
/// `Config`: a DaemonConfig. `Exchange`: `gateway_wake`, `link`. The destructor of a gateway calls `stop`
/// first of all, for the thread uses its members.
template <class Config, class Exchange>
class GatewayBase {
 public:
  GatewayBase(const GatewayBase&) = delete;
  GatewayBase& operator=(const GatewayBase&) = delete;

  /// What the realtime thread asked for and was granted, for RealtimeStatus. Before `start`.
  void set_realtime(const rt::RealtimeSettings& wanted, const rt::Grants& granted) {
    common_.set_realtime(wanted, granted);
  }

  /// Starts the thread; once. Throws std::system_error when there is no thread to be had.
  void start() {
    metrics_.emplace(
        config_.metrics, [this](const EventText& event) { post(event); },
        [this](std::uint64_t write_failures) { return metrics_text(write_failures); });
    thread_.start();
  }

  /// Answers every open request, waits a little until the clients have the replies, and ends the thread.
  /// Whether the realtime thread has ended before does not matter; what it has left in the exchange is still
  /// told. Further calls do nothing.
  void stop() noexcept {
    thread_.stop();
    metrics_.reset();
  }

  /// Passes over everything that may have come, so far: stands still for longer than a second only when the
  /// thread does. Any thread.
  std::uint64_t passes() const noexcept { return thread_.passes(); }

  /// Publishes an event of another thread. Any thread; returns at once. More than `PostedEvents::kMost` that
  /// wait are lost.
  void post(const EventText& event) {
    posted_.post(event);
    exchange_.gateway_wake.signal();
  }

  /// Publishes what is true around the bus. Any thread; returns at once.
  void set_surroundings(const Surroundings& surroundings) {
    new_surroundings_.give(surroundings);
    exchange_.gateway_wake.signal();
  }

  /// Takes over what can change while running; everything else in `config` is ignored. Any thread; returns at
  /// once.
  void reload(const Config& config) {
    new_configuration_.give(config);
    exchange_.gateway_wake.signal();
  }

  /// A line that is no simulation is in operation. Any thread.
  bool in_run() const noexcept { return in_run_.load(std::memory_order_relaxed); }

  /// Shows what waits for a restart, and publishes an event when that has changed. Any thread; returns at
  /// once.
  void set_pending_restart(const PendingRestart& pending) {
    new_pending_restart_.give(pending);
    exchange_.gateway_wake.signal();
  }

 protected:
  /// Sets up the topics of every protocol; nothing is taken or published before `start`. `exchange`,
  /// `participant` and `journal` must outlive the gateway. `identity`: of this start; `protocol`: as
  /// bus.protocol names it; `slaves`: numbers that requests can be for. Throws gateway::dds::SetupError.
  GatewayBase(const Config& config, Exchange& exchange, const gateway::dds::Participant& participant,
              JournalSink& journal, const DaemonIdentity& identity, std::string_view protocol, int slaves)
      : config_(config),
        exchange_(exchange),
        events_(participant, journal, config.bus.name),
        common_(participant, events_, config, protocol, identity),
        second_daemon_(participant, signal_, events_, config.bus.name, identity),
        trail_(journal, events_, config.bus.name, slaves),
        status_line_([bus = config.bus.name](const std::string& text) { service::status(bus, text); }),
        network_(participant, events_, common_),
        thread_(
            exchange.gateway_wake, signal_,
            [this](bool samples_may_wait) {
              if (const auto around = new_surroundings_.take()) take_surroundings(*around);
              // What has come is taken before its reader goes.
              if (network_.due(std::chrono::steady_clock::now())) {
                (void)pass(true);
                network_.move(std::chrono::steady_clock::now());
                samples_may_wait = true;
              }
              return pass(samples_may_wait);
            },
            [this] {
              end();
              trail_.finish(std::chrono::steady_clock::now());
              events_.finish(std::chrono::steady_clock::now());
            }) {
    trail_.set_record_each(config.access.record_each);
  }
  ~GatewayBase() = default;

  /// One pass over everything that may have come; returns when the next is due at the latest. The readers are
  /// asked only when `samples_may_wait`: that costs more than all the rest of a pass.
  virtual SteadyTime pass(bool samples_may_wait) = 0;
  /// The last of the thread: tells what is left, and answers every open request.
  virtual void end() = 0;
  /// The text of the metrics file.
  virtual std::string metrics_text(std::uint64_t write_failures) const = 0;

  /// Takes over the rights and the greatest age of requests of a configuration that was read again. True:
  /// there was one.
  bool take_access(SteadyTime now) {
    const auto taken = new_configuration_.take();
    if (!taken) return false;
    config_.access = taken->access;
    config_.dds.request_max_age = taken->dds.request_max_age;
    common_.set_access(config_.access);
    trail_.set_record_each(config_.access.record_each);
    tell_reloaded(now);
    return true;
  }
  void tell_reloaded(SteadyTime now) {
    events_.publish(
        {gateway_SEVERITY_INFO, "configuration_reloaded", -1, "the configuration was read again", {}}, now);
  }

  /// Tells as events what changed of bus and controller.
  void tell_bus(const can::ControllerStatus& from, const can::ControllerStatus& to, SteadyTime now) {
    for (const EventText& event : bus_events(from, to, config_.bus, link())) events_.publish(event, now);
  }

  /// Tells as events what found no room on the bus. While the bus cannot be used nothing has: that has an event of its
  /// own.
  void tell_left_out(LossRow& row, std::uint64_t left_out, const can::ControllerStatus& controller,
                     SteadyTime now) {
    constexpr std::chrono::milliseconds kRoomAgain{500};
    // What was left out until it ended is counted in this pass, or later.
    const bool blocked = obstacle_of(controller) != can::Obstacle::none;
    if (std::exchange(was_blocked_, blocked) || blocked) room_again_ = now + kRoomAgain;
    if (now < room_again_) row.pass_over(left_out);
    row.tell(left_out, events_, now);
  }

  /// The interface as the thread that watches it found it last: not older than what the realtime thread
  /// reports of it.
  const can::LinkFacts& link() {
    if (exchange_.link.read(link_)) common_.set_link(link_);
    return link_;
  }

  /// Publishes the status of every protocol; `jobs`: the desk of the requests. Returns when to call again.
  template <class Jobs>
  SteadyTime tell_common(const CommonSnapshot& snapshot, const Jobs& jobs, SteadyTime now) {
    link();
    in_run_.store(snapshot.in_run && config_.bus.kind != BusKind::simulated, std::memory_order_relaxed);
    if (const auto pending = new_pending_restart_.take()) take_pending_restart(*pending, now);
    common_.set_clients(jobs.clients(), jobs.rejections());
    common_.set_snapshot(snapshot);
    return common_.step(now);
  }

  /// When the next pass is due: the earliest of these, and of what every gateway waits for.
  SteadyTime earliest(SteadyTime due, std::initializer_list<std::optional<SteadyTime>> others,
                      SteadyTime now) {
    const auto take = [&due](const std::optional<SteadyTime>& next) {
      if (next) due = std::min(due, *next);
    };
    for (const auto& next : others) take(next);
    take(events_.tick(now));
    take(metrics_->step(now));
    return due;
  }

  Config config_;  ///< gateway thread only, once it runs
  Exchange& exchange_;
  gateway::dds::DataSignal signal_;  ///< before everything that raises it
  EventPublisher events_;
  CommonStatus common_;
  SecondDaemon second_daemon_;
  AuditTrail trail_;
  std::optional<MetricsDesk> metrics_;  ///< from `start` to `stop`
  NewConfiguration<Config> new_configuration_;
  NewConfiguration<Surroundings> new_surroundings_;
  NewConfiguration<PendingRestart> new_pending_restart_;
  PostedEvents posted_;
  StatusLine status_line_;

 private:
  void take_surroundings(const Surroundings& around) {
    common_.set_surroundings(around);
    network_.set(around.network, std::chrono::steady_clock::now());
  }

  void take_pending_restart(const PendingRestart& pending, SteadyTime now) {
    if (!common_.set_pending_restart(pending) || pending.reason.empty()) return;
    events_.publish({gateway_SEVERITY_WARNING,
                     "restart_pending",
                     -1,
                     pending.reason + ": restart the daemon when the line may stop",
                     {}},
                    now);
  }

  std::atomic<bool> in_run_{false};
  SteadyTime room_again_;
  bool was_blocked_ = false;  ///< the bus could not be used, in the pass before
  can::LinkFacts link_;
  GatewayNetwork network_;
  GatewayThread thread_;
};

}  // namespace cansyncd
