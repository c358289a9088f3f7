#pragma once

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>

#include "can/bus.h"
#include "can/link_facts.h"
#include "daemon/desk/audit.h"
#include "daemon/desk/event_text.h"
#include "daemon/desk/gateway_events.h"
#include "daemon/desk/gateway_thread.h"
#include "daemon/desk/second_daemon.h"
#include "daemon/service/daemon_identity.h"
#include "daemon/service/journal.h"
#include "daemon/service/new_configuration.h"
#include "daemon/status/bus_events.h"
#include "daemon/status/common_status.h"
#include "daemon/status/metrics_desk.h"
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

  /// Takes over what can change while running; everything else in `config` is ignored. Any thread; returns at
  /// once.
  void reload(const Config& config) {
    new_configuration_.give(config);
    exchange_.gateway_wake.signal();
  }

 protected:
  /// Sets up the topics of every protocol; nothing is taken or published before `start`. `exchange`,
  /// `participant` and `journal` must outlive the gateway. `identity`: of this start; `slaves`: numbers that
  /// requests can be for. Throws gateway::dds::SetupError.
  GatewayBase(const Config& config, Exchange& exchange, const gateway::dds::Participant& participant,
              JournalSink& journal, const DaemonIdentity& identity, const ProtocolFacts& protocol, int slaves)
      : config_(config),
        exchange_(exchange),
        events_(participant, journal, config.bus.name),
        common_(participant, events_, config, protocol, identity),
        second_daemon_(participant, signal_, events_, config.bus.name, identity),
        trail_(journal, events_, config.bus.name, slaves),
        thread_(
            exchange.gateway_wake, signal_, [this](bool samples_may_wait) { return pass(samples_may_wait); },
            [this] { end(); }) {}
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
    tell_reloaded(now);
    return true;
  }
  void tell_reloaded(SteadyTime now) {
    events_.publish(
        {gateway_SEVERITY_INFO, "configuration_reloaded", -1, "the configuration was read again", {}}, now);
  }

  /// Tells as events what changed of bus and controller.
  void tell_bus(const can::ControllerStatus& from, const can::ControllerStatus& to, SteadyTime now) {
    for (const EventText& event : bus_events(from, to, config_.bus)) events_.publish(event, now);
  }

  /// Publishes the status of every protocol; `jobs`: the desk of the requests. Returns when to call again.
  template <class Jobs>
  SteadyTime tell_common(const CommonSnapshot& snapshot, const Jobs& jobs, SteadyTime now) {
    if (can::LinkFacts link; exchange_.link.read(link)) common_.set_link(link);
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
  PostedEvents posted_;

 private:
  GatewayThread thread_;
};

}  // namespace cansyncd
