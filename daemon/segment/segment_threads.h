#pragma once

#include <optional>
#include <string>

#include "can/link_facts.h"
#include "daemon/bus/bus_choice.h"
#include "daemon/config/daemon_config.h"
#include "daemon/recorder/flight_desk.h"
#include "daemon/segment/segment_start.h"
#include "daemon/service/service_log.h"
#include "rt/realtime_thread.h"

namespace cansyncd {

/// The threads of a segment, whatever its protocol, begun and ended in the order that no request and no event
/// is lost by. The last member of its segment: everything it is given must outlive it. Main thread.
///
/// `Loop`: `run`, `request_stop`, `wake_ups`. `Gateway`: `set_realtime`, `start`, `stop`. `Exchange`: `link`,
/// `gateway_wake`.
template <class Loop, class Gateway, class Exchange>
class SegmentThreads {
 public:
  SegmentThreads(const ServiceLog& log, BusChoice& bus, FlightDesk& flight, Gateway& gateway, Loop& loop,
                 Exchange& exchange) noexcept
      : log_(log), bus_(bus), flight_(flight), gateway_(gateway), loop_(loop), exchange_(exchange) {}

  /// Returns once the realtime thread runs. Throws rt::RealtimeError when realtime is enforced and not
  /// granted, std::system_error without threads, std::runtime_error when the thread does not come to run.
  void start(const RealtimeConfig& config) {
    const rt::RealtimeSettings settings = realtime_settings(config);
    realtime_.emplace(settings, [this] { loop_.run(); });
    tell_grants(log_, settings, realtime_->grants());
    gateway_.set_realtime(settings, realtime_->grants());
    if (const std::string advice = bus_.advice(); !advice.empty())
      log_.say(LogPriority::warning, "not_one_shot", advice);
    bus_.start([this](const can::LinkFacts& facts) {
      exchange_.link.write(facts);
      exchange_.gateway_wake.signal();
    });
    gateway_.start();
    wait_until_running([this] { return loop_.wake_ups(); });
  }

  /// Open requests are answered first by the realtime thread, then by the gateway. Does nothing before
  /// `start` and the second time. `trace`: the file of a simulated line's trace, told of in the journal.
  void stop(const std::string& trace) noexcept {
    if (!realtime_) return;
    loop_.request_stop();
    realtime_.reset();
    flight_.stop();
    bus_.stop();
    gateway_.stop();
    tell_trace(log_, trace, bus_.close_trace());
  }

 private:
  const ServiceLog& log_;
  BusChoice& bus_;
  FlightDesk& flight_;
  Gateway& gateway_;
  Loop& loop_;
  Exchange& exchange_;
  std::optional<rt::RealtimeThread> realtime_;
};

}  // namespace cansyncd
