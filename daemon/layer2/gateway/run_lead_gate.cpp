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
    : reader_(participant, signal),
      events_(events),
      daemon_(daemon),
      name_(std::move(name)),
      exchange_(exchange) {}

bool RunLeadGate::take_samples(SteadyTime now) {
  const bool more = reader_.take([](const layer2_RunLead& /*sample*/) { return 0u; },
                                 [](const layer2_RunLead& /*sample*/) { return false; },
                                 [&](const layer2_RunLead& sample, const dds_sample_info_t& info) {
                                   take(sample, info.publication_handle, now);
                                 });
  if (reader_.lost(0, arbiter_)) gone("has gone", true, now);
  reader_.tell_dropped(events_, now);
  return more;
}

void RunLeadGate::set_read_only(bool read_only, SteadyTime now) {
  read_only_ = read_only;
  if (read_only && arbiter_.owner().handle != 0)
    gone("is not heard while access.read_only is set", false, now);
}

void RunLeadGate::gone(std::string_view how, bool fault, SteadyTime now) {
  const std::string who = program();
  arbiter_.free();
  set(false, fmt::format("{} {}, which run and stop follow: stop", who, how), fault, now);
}

void RunLeadGate::take(const layer2_RunLead& sample, WriterHandle writer, SteadyTime now) {
  const bool counts = follows() && gateway::dds::text(sample.client_name) == name_ &&
                      gateway::dds::addressee(gateway::dds::daemon_of(sample), daemon_) ==
                          gateway::dds::Addressee::this_daemon;
  if (!counts) return;
  if (read_only_) {
    if (!refusals_.add(1, now)) return;
    EventText event{
        gateway_SEVERITY_WARNING, "run_lead_changed", -1,
        fmt::format("{} says: {}; it is not heard while access.read_only is set, and has to say it "
                    "again afterwards",
                    name_, sample.run ? "run" : "stop"),
        std::nullopt};
    event.client = name_;
    events_.publish(event, now);
    return;
  }
  const TopicWriter from = reader_.writer_of(sample, writer);
  const WriterArbiter::Claim claim = arbiter_.claim(writer, from.identity.strength);
  if (claim == WriterArbiter::Claim::waits) return tell_waiting(events_, arbiter_, from, now);
  if (claim == WriterArbiter::Claim::keeps && sample.run == run_) return;
  if (claim != WriterArbiter::Claim::keeps) arbiter_.give(from);
  set(sample.run, fmt::format("{} says: {}", name_, sample.run ? "run" : "stop"), false, now);
}

void RunLeadGate::set(bool run, std::string text, bool fault, SteadyTime now) {
  run_ = run;
  wanted_ = run;
  stopped_ = stopped_ || !run;
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
  (void)refusals_.take_over(now);
  if (flush()) return refusals_.next();
  return now + kRetry;
}

}  // namespace cansyncd
