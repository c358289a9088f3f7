#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <thread>
#include <utility>

#include "daemon/loop/deadline_loop.h"
#include "daemon/service/daemon_identity.h"
#include "daemon/service/journal.h"
#include "dds/participant.h"
#include "disturbed_bus.h"
#include "sim/line.h"

namespace given {

/// Returns when the gateway has seen all that has come from either side.
template <class Gateway, class Exchange>
void settle(Gateway& gateway, Exchange& exchange) {
  const std::uint64_t before = gateway.passes();
  // The pass that is under way may have looked already.
  while (gateway.passes() < before + 2) {
    exchange.gateway_wake.signal();
    std::this_thread::yield();
  }
}

/// So much time passes, a millisecond at a time, each of which the gateway sees. `step(until)` lets it pass on the bus.
template <class DaemonOf, class Step>
void pass_time(DaemonOf& daemon, can::Time span, Step&& step) {
  const can::Time end = daemon.bus.now() + span;
  settle(daemon.gateway, daemon.exchange);
  for (can::Time now = daemon.bus.now(); now < end; now = daemon.bus.now()) {
    step(std::min(end, now + std::chrono::milliseconds(1)));
    settle(daemon.gateway, daemon.exchange);
  }
}

/// The daemon but for its main program: its gateway over DDS on a thread of its own, and its machine on a simulated
/// line in virtual time, which goes on in `run` alone. `Parts`: as `DeadlineSegment` has them.
template <class Parts>
class Daemon {
 public:
  using File = typename Parts::File;

  /// `start`: over 0, of this start alone.
  Daemon(File file, const gateway::dds::ParticipantOptions& place, cansyncd::JournalSink& journal,
         std::uint8_t start)
      : file_(std::move(file)),
        identity{0xDA, start},
        participant_(place),
        line_({.bits_per_second = file_.config.bus.bits_per_second, .transmit_queue = 64},
              std::move(Parts::bus_plan(file_.config).sim.nodes)),
        bus(line_),
        exchange(Parts::exchange(file_.config)),
        gateway(Parts::given(file_), exchange, participant_, journal, identity),
        machine_(virtual_time(Parts::machine_settings(file_.config, nullptr, {})), bus, exchange),
        loop_(machine_, bus) {}
  ~Daemon() { stop(); }
  Daemon(const Daemon&) = delete;
  Daemon& operator=(const Daemon&) = delete;

  void start() {
    gateway.start();
    loop_.begin();
    runs_ = true;
  }
  /// As a stop of the service does it.
  void stop() {
    if (!std::exchange(runs_, false)) return;
    loop_.end();
    gateway.stop();
  }
  /// So much time passes, in which the gateway sees every millisecond.
  void run(can::Time span) {
    pass_time(*this, span, [this](can::Time until) { loop_.turn(until); });
  }

 private:
  template <class Settings>
  static Settings virtual_time(Settings settings) {
    settings.wall_clock = nullptr;
    return settings;
  }

  File file_;

 public:
  const cansyncd::DaemonIdentity identity;

 private:
  gateway::dds::Participant participant_;
  sim::Line line_;

 public:
  DisturbedBus bus;
  typename Parts::Exchange exchange;
  typename Parts::Gateway gateway;

 private:
  typename Parts::Machine machine_;
  cansyncd::DeadlineLoop<typename Parts::Machine> loop_;
  bool runs_ = false;
};

}  // namespace given
