#include "daemon/layer2/gateway/run_lead_gate.h"

#include <fmt/format.h>

#include <utility>

#include "dds/bounded_text.h"
#include "dds/daemon_identity.h"
#include "layer2/dds/topics.h"

namespace cansyncd {
namespace {

/// Without room for an order the gate tries again after so long.
constexpr std::chrono::milliseconds kRetry{10};
/// Of orders that nobody waits for.
constexpr layer2::OrderId kNobody = 0;

}  // namespace

RunLeadGate::RunLeadGate(const gateway::dds::Participant& participant, gateway::dds::DataSignal& signal,
                         EventPublisher& events, const DaemonIdentity& daemon, std::string name,
                         Layer2Exchange& exchange)
    : writer_(participant, signal),
      events_(events),
      daemon_(daemon),
      name_(std::move(name)),
      exchange_(exchange) {}

bool RunLeadGate::take_samples(SteadyTime now) {
  const bool more = writer_.take(
      [&](const layer2_RunLead& sample, dds_instance_handle_t writer) { take(sample, writer, now); });
  if (writer_.gone()) {
    const std::string who = writer_.name();
    writer_.own(0);
    set(false, fmt::format("{} has gone, which run and stop follow: stop", who), true, now);
  }
  return more;
}

void RunLeadGate::take(const layer2_RunLead& sample, dds_instance_handle_t writer, SteadyTime now) {
  if (!follows()) return;
  const bool counts = gateway::dds::text(sample.client_name) == name_ &&
                      gateway::dds::addressee(gateway::dds::daemon_of(sample), daemon_) ==
                          gateway::dds::Addressee::this_daemon;
  if (!counts) {
    // It is the stronger one, so that a stop of the program that is followed would not come any more.
    if (writer_.owner() == 0 || writer_.owner() == writer) return;
    writer_.own(0);
    return set(false,
               fmt::format("a stronger writer of RunLead, which calls itself '{}' and is not followed, has "
                           "displaced {}: stop",
                           gateway::dds::text(sample.client_name), name_),
               true, now);
  }
  const bool other = writer_.owner() != writer;
  if (other) writer_.own(writer);
  if (!other && sample.run == run_) return;
  set(sample.run, fmt::format("{} says: {}", name_, sample.run ? "run" : "stop"), false, now);
}

void RunLeadGate::set(bool run, std::string text, bool fault, SteadyTime now) {
  run_ = run;
  wanted_ = run;
  EventText event{fault ? gateway_SEVERITY_ERROR : gateway_SEVERITY_INFO, "run_lead_changed", -1,
                  std::move(text), std::nullopt};
  event.client = name_;
  events_.publish(event, now);
  (void)flush();
}

/// True: nothing waits.
bool RunLeadGate::flush() {
  if (!wanted_) return true;
  layer2::ControlOrder order;
  order.id = kNobody;
  order.what = *wanted_ ? layer2::Control::run : layer2::Control::stop;
  if (exchange_.requests.try_push(order)) wanted_.reset();
  return !wanted_;
}

std::optional<SteadyTime> RunLeadGate::tick(SteadyTime now) {
  if (flush()) return std::nullopt;
  return now + kRetry;
}

}  // namespace cansyncd
