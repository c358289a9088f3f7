#pragma once

#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include "can/link_facts.h"
#include "daemon/bus/bus_choice.h"
#include "daemon/recorder/flight_desk.h"
#include "daemon/segment/segment_start.h"
#include "daemon/service/service_log.h"
#include "daemon_config/daemon_config.h"
#include "rt/realtime_thread.h"

namespace cansyncd {

/// What runs for one bus of a segment beside the realtime thread. Everything it is given must outlive it.
/// Main thread.
///
/// `Gateway`: `set_realtime`, `start`, `stop`. `Exchange`: `link`, `gateway_wake`.
template <class Gateway, class Exchange>
class SegmentSide {
 public:
  SegmentSide(const ServiceLog& log, const DaemonConfig& config, BusChoice& bus, FlightDesk& flight,
              Gateway& gateway, Exchange& exchange) noexcept
      : log_(log), config_(config), bus_(bus), flight_(flight), gateway_(gateway), exchange_(exchange) {}

  /// Once the realtime thread runs. Throws std::system_error without threads.
  void start(const rt::RealtimeSettings& wanted, const rt::Grants& granted) {
    gateway_.set_realtime(wanted, granted);
    if (const std::string advice = bus_.advice(); !advice.empty())
      log_.say(LogPriority::warning, "not_one_shot", advice);
    bus_.start([&exchange = exchange_](const can::LinkFacts& facts) {
      exchange.link.write(facts);
      exchange.gateway_wake.signal();
    });
    gateway_.start();
  }

  /// Once that thread has ended: the gateway answers what is open, and a simulated line's trace is told of.
  void stop() noexcept {
    flight_.stop();
    bus_.stop();
    gateway_.stop();
    tell_trace(log_, config_.sim.trace, bus_.close_trace());
  }

 private:
  const ServiceLog& log_;
  const DaemonConfig& config_;
  BusChoice& bus_;
  FlightDesk& flight_;
  Gateway& gateway_;
  Exchange& exchange_;
};

/// The threads of a segment, whatever its protocol, begun and ended in the order that no request and no event
/// is lost by. The last member of its segment: everything it is given must outlive it. Main thread.
///
/// `Loop`: `run`, `request_stop`, `wake_ups`. `Sides`: a SegmentSide for each bus.
template <class Loop, class... Sides>
class SegmentThreads {
 public:
  SegmentThreads(const ServiceLog& log, Loop& loop, Sides... sides) noexcept
      : log_(log), loop_(loop), sides_(std::move(sides)...) {}

  /// Returns once the realtime thread runs. Throws rt::RealtimeError when realtime is enforced and not
  /// granted, std::system_error without threads, std::runtime_error when the thread does not come to run.
  void start(const RealtimeConfig& config) {
    const rt::RealtimeSettings settings = realtime_settings(config);
    realtime_.emplace(settings, [this] { loop_.run(); });
    tell_grants(log_, settings, realtime_->grants());
    std::apply([&](Sides&... sides) { (sides.start(settings, realtime_->grants()), ...); }, sides_);
    wait_until_running([this] { return loop_.wake_ups(); });
  }

  /// Ends the realtime thread, which answers the open requests first: from then on nothing is sent. Does nothing
  /// before `start` and the second time.
  void end_realtime() noexcept {
    if (!realtime_) return;
    loop_.request_stop();
    realtime_->join();
  }

  /// And ends the rest: the gateways give their answers. Does nothing before `start` and the second time.
  void stop() noexcept {
    if (!realtime_) return;
    end_realtime();
    realtime_.reset();
    std::apply([](Sides&... sides) { (sides.stop(), ...); }, sides_);
  }

 private:
  const ServiceLog& log_;
  Loop& loop_;
  std::tuple<Sides...> sides_;
  std::optional<rt::RealtimeThread> realtime_;
};

}  // namespace cansyncd
