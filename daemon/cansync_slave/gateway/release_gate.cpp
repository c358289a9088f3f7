#include "daemon/cansync_slave/gateway/release_gate.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "cansync_slave/dds/topics.h"
#include "cansync_slave/dds/validate.h"
#include "dds/daemon_identity.h"

namespace cansyncd {
namespace {

using gateway::dds::Denial;

/// Without room for a withdrawal the gate tries again after so long.
constexpr std::chrono::milliseconds kWithdrawalRetry{10};

cansync::Channel channel_at(unsigned index) noexcept {
  return index == 0 ? cansync::Channel::one : cansync::Channel::two;
}

}  // namespace

ReleaseGate::ReleaseGate(const gateway::dds::Participant& participant, gateway::dds::DataSignal& signal,
                         EventPublisher& events, const DaemonIdentity& daemon, SlaveExchange& exchange)
    : reader_(participant, signal), events_(events), daemon_(daemon), exchange_(exchange) {}

bool ReleaseGate::take_samples(SteadyTime now, std::int64_t wall) {
  // A key that is no telegram has no owner.
  const auto number = [](const cansync_slave_ActualRelease& sample) { return sample.telegram - 1u; };
  const auto gives_up = [](const cansync_slave_ActualRelease& sample) { return sample.given_up; };
  const bool more = reader_.take(
      number, gives_up, [&](const cansync_slave_ActualRelease& sample, const dds_sample_info_t& info) {
        take(sample, info.publication_handle, std::chrono::nanoseconds(wall - info.source_timestamp), now);
      });
  for (unsigned channel = 0; channel < cansync::kChannels; ++channel) {
    if (reader_.lost(channel, arbiters_[channel]))
      lost(channel,
           reader_.left(arbiters_[channel].owner().handle) ? "has gone without giving up"
                                                           : "is silent, and loses",
           false, now);
  }
  reader_.tell_dropped(events_, now);
  return more;
}

void ReleaseGate::take(const cansync_slave_ActualRelease& sample, WriterHandle from,
                       std::chrono::nanoseconds age, SteadyTime now) {
  const bool known = sample.telegram == 1 || sample.telegram == 2;
  const unsigned channel = sample.telegram == 2 ? 1 : 0;
  WriterArbiter& arbiter = arbiters_[channel];
  if (sample.given_up) {
    if (!known) return;
    arbiter.forget(from);
    if (arbiter.owner().handle == from) lost(channel, "gives up", true, now);
    return;
  }
  if (const auto problem = problem_of(sample, age)) {
    refuse(channel, *problem, now);
    return;
  }
  const TopicWriter writer = reader_.writer_of(sample, from);
  const WriterArbiter::Claim claim = arbiter.claim(writer.handle, writer.identity.strength);
  if (claim == WriterArbiter::Claim::waits) {
    tell_waiting(events_, arbiter, writer, now);
    return;
  }
  if (claim != WriterArbiter::Claim::keeps) new_owner(channel, writer, now);
  ReleaseOrder order;
  order.channel = channel_at(channel);
  order.valid = sample.valid;
  order.intervals = sample.wait_intervals == 0 ? 1 : sample.wait_intervals;
  std::copy(std::begin(sample.raw), std::end(sample.raw), order.values.begin());
  if (!flush() || !exchange_.releases.try_push(order))
    refuse(channel, {gateway_CAUSE_QUEUE_FULL, "too many releases wait for the realtime thread; give fewer"},
           now);
}

gateway::dds::Problem ReleaseGate::problem_of(const cansync_slave_ActualRelease& sample,
                                              std::chrono::nanoseconds age) const {
  if (auto wrong = cansync_slave::dds::check(sample)) return wrong;
  if (read_only_)
    return Denial{
        gateway_CAUSE_READ_ONLY,
        "the daemon is read-only; set access.read_only to false in the configuration and reload the daemon"};
  if (gateway::dds::addressee(gateway::dds::daemon_of(sample), daemon_) !=
      gateway::dds::Addressee::this_daemon)
    return Denial{gateway_CAUSE_OTHER_DAEMON,
                  "meant for another start of the daemon: what was released before it is not sent; let the "
                  "program take up its telegrams"};
  if (age > kMaximumAge || age < -kMaximumAge)
    return Denial{gateway_CAUSE_STALE,
                  fmt::format("written {:.0f} ms ago; allowed: {} ms; check the load and the clocks",
                              static_cast<double>(age.count()) / 1e6, kMaximumAge.count())};
  return std::nullopt;
}

void ReleaseGate::new_owner(unsigned channel, const TopicWriter& writer, SteadyTime now) {
  WriterArbiter& arbiter = arbiters_[channel];
  const gateway::dds::WriterIdentity& who = writer.identity;
  const bool first = arbiter.owner().handle == 0;
  EventText event{
      first ? gateway_SEVERITY_INFO : gateway_SEVERITY_WARNING, "actual_writer_began", -1,
      fmt::format("{} (strength {}) releases the actual values of telegram {}{}", who.who, who.strength,
                  channel + 1, first ? "" : ", in place of " + arbiter.owner().identity.who),
      std::nullopt};
  event.client = who.who;
  events_.publish(event, now);
  arbiter.give(writer);
}

void ReleaseGate::lost(unsigned channel, const char* how, bool wanted, SteadyTime now) {
  WriterArbiter& arbiter = arbiters_[channel];
  if (arbiter.owner().handle == 0) return;
  withdrawals_[channel] = true;
  (void)flush();
  const std::string& who = arbiter.owner().identity.who;
  EventText event{wanted ? gateway_SEVERITY_INFO : gateway_SEVERITY_ERROR, "actual_writer_lost", -1,
                  fmt::format("{} {} telegram {}: nothing more is released", who, how, channel + 1),
                  std::nullopt};
  event.client = who;
  events_.publish(event, now);
  arbiter.free();
}

void ReleaseGate::set_read_only(bool read_only, SteadyTime now) {
  read_only_ = read_only;
  for (unsigned channel = 0; read_only && channel < cansync::kChannels; ++channel)
    lost(channel, "may not write while access.read_only is set, and loses", true, now);
}

bool ReleaseGate::flush() {
  bool empty = true;
  for (unsigned channel = 0; channel < cansync::kChannels; ++channel) {
    if (!withdrawals_[channel]) continue;
    ReleaseOrder withdraw;
    withdraw.channel = channel_at(channel);
    withdrawals_[channel] = !exchange_.releases.try_push(withdraw);
    empty = empty && !withdrawals_[channel];
  }
  return empty;
}

void ReleaseGate::refuse(unsigned channel, const Denial& denial, SteadyTime now) {
  if (!refusals_.add(1, now)) return;
  events_.publish({gateway_SEVERITY_WARNING, "actual_refused", -1,
                   fmt::format("actual values of telegram {} are not taken: {}", channel + 1, denial.reason),
                   std::nullopt},
                  now);
}

std::optional<SteadyTime> ReleaseGate::tick(SteadyTime now) {
  (void)refusals_.take_over(now);
  std::optional<SteadyTime> due = refusals_.next();
  if (!flush()) due = due ? std::min(*due, now + kWithdrawalRetry) : now + kWithdrawalRetry;
  return due;
}

}  // namespace cansyncd
