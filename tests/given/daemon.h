#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "daemon/loop/deadline_loop.h"
#include "daemon/service/daemon_identity.h"
#include "daemon/service/journal.h"
#include "dds/participant.h"
#include "disturbed_bus.h"
#include "sim/line.h"

namespace given {

/// The daemon but for its main program: its gateway over DDS on a thread of its own, and its machine on a simulated
/// line in virtual time, which goes on in `run` alone. Constructed with its file, where it is, and the start that
/// this is.
class Daemon {
 public:
  virtual ~Daemon() = default;
  Daemon(const Daemon&) = delete;
  Daemon& operator=(const Daemon&) = delete;

  virtual void start() = 0;
  /// As a stop of the service does it. Further calls do nothing.
  virtual void stop() = 0;
  /// So much time passes.
  virtual void run(can::Time span) = 0;
  /// The gateway sees all that has come from either side, while no time passes.
  virtual void settle() = 0;
  virtual void set_read_only(bool read_only) = 0;
  /// The file is read again and says this.
  virtual void reload(const std::string& text) = 0;
  virtual DisturbedBus& bus() = 0;

  const cansyncd::DaemonIdentity identity;

 protected:
  /// `start`: over 0, of this start alone.
  explicit Daemon(std::uint8_t start) : identity{0xDA, start} {}
};

/// Makes a start of the daemon of a file.
using MakeDaemon = std::function<std::unique_ptr<Daemon>(const std::string& text,
                                                         const gateway::dds::ParticipantOptions& place,
                                                         cansyncd::JournalSink& journal, std::uint8_t start)>;

template <class Made>
std::unique_ptr<Daemon> make_daemon(const std::string& text, const gateway::dds::ParticipantOptions& place,
                                    cansyncd::JournalSink& journal, std::uint8_t start) {
  return std::make_unique<Made>(text, place, journal, start);
}

/// What `Parts` reads of a text without problems: as `DeadlineSegment` has them.
template <class Parts>
typename Parts::File load(const std::string& text) {
  typename Parts::File file = Parts::load({"given.toml", text}, {});
  for (const auto& problem : file.problems) ADD_FAILURE() << problem.text;
  return file;
}

template <class Gateway, class Exchange>
void settle(Gateway& gateway, Exchange& exchange) {
  const std::uint64_t before = gateway.passes();
  // The pass that is under way may have looked already.
  while (gateway.passes() < before + 2) {
    exchange.gateway_wake.signal();
    std::this_thread::yield();
  }
}

/// So much time passes, 5 ms at a time, after each of which the gateway sees all. `step(until)` lets it pass on the bus.
template <class Step>
void pass_time(Daemon& daemon, can::Time span, Step&& step) {
  const can::Time end = daemon.bus().now() + span;
  daemon.settle();
  for (can::Time now = daemon.bus().now(); now < end; now = daemon.bus().now()) {
    step(std::min(end, now + std::chrono::milliseconds(5)));
    daemon.settle();
  }
}

template <class Gateway, class Config>
void set_read_only(Gateway& gateway, Config config, bool read_only) {
  config.access.read_only = read_only;
  gateway.reload(config);
}

template <class Settings>
Settings in_virtual_time(Settings settings) {
  settings.wall_clock = nullptr;
  return settings;
}

/// Of a protocol that `DeadlineLoop` drives. `Parts`: as `DeadlineSegment` has them.
template <class Parts>
class DeadlineDaemon final : public Daemon {
 public:
  DeadlineDaemon(const std::string& text, const gateway::dds::ParticipantOptions& place,
                 cansyncd::JournalSink& journal, std::uint8_t start)
      : Daemon(start),
        file_(load<Parts>(text)),
        participant_(place),
        line_({.bits_per_second = file_.config.bus.bits_per_second, .transmit_queue = 64},
              std::move(Parts::bus_plan(file_.config).sim.nodes)),
        bus_(line_),
        exchange_(Parts::exchange(file_.config)),
        gateway_(Parts::given(file_), exchange_, participant_, journal, identity),
        machine_(in_virtual_time(Parts::machine_settings(file_.config, nullptr, {nullptr, &line_})), bus_,
                 exchange_),
        loop_(machine_, bus_) {}
  ~DeadlineDaemon() override { stop(); }

  void start() override {
    gateway_.start();
    loop_.begin();
    runs_ = true;
  }
  void stop() override {
    if (!std::exchange(runs_, false)) return;
    loop_.end();
    gateway_.stop();
  }
  void run(can::Time span) override {
    pass_time(*this, span, [this](can::Time until) { loop_.turn(until); });
  }
  void settle() override { given::settle(gateway_, exchange_); }
  void set_read_only(bool read_only) override { given::set_read_only(gateway_, file_.config, read_only); }
  void reload(const std::string& text) override { gateway_.reload(load<Parts>(text).config); }
  DisturbedBus& bus() override { return bus_; }

 private:
  typename Parts::File file_;
  gateway::dds::Participant participant_;
  sim::Line line_;
  DisturbedBus bus_;
  typename Parts::Exchange exchange_;
  typename Parts::Gateway gateway_;
  typename Parts::Machine machine_;
  cansyncd::DeadlineLoop<typename Parts::Machine> loop_;
  bool runs_ = false;
};

}  // namespace given
