#include "daemon/cansync_slave/gateway/release_gate.h"

#include <fmt/format.h>

#include <iterator>
#include <utility>

#include "cansync_slave/dds/topics.h"
#include "cansync_slave/dds/validate.h"
#include "dds/daemon_identity.h"

namespace cansyncd {
namespace {

using gateway::dds::Denial;

cansync::Channel channel_at(unsigned index) noexcept {
  return index == 0 ? cansync::Channel::one : cansync::Channel::two;
}

}  // namespace

ReleaseGate::ReleaseGate(const gateway::dds::Participant& participant, gateway::dds::DataSignal& signal,
                         EventPublisher& events, const DaemonIdentity& daemon, SlaveExchange& exchange)
    : reader_(participant, &signal),
      events_(events),
      daemon_(daemon),
      exchange_(exchange),
      writers_(participant, reader_.handle()) {}

bool ReleaseGate::take_samples(SteadyTime now) {
  without_writer_ = {};
  const auto count = reader_.take_batch([&](const cansync_slave_ActualRelease& sample,
                                            const dds_sample_info_t& info) { take(sample, info, now); });
  const bool changed = writers_.look();
  for (unsigned channel = 0; channel < cansync::kChannels; ++channel) {
    const Writer owner = owners_[channel];
    if (without_writer_[channel] || (changed && owner != 0 && writers_.gone(owner)))
      lost(channel, false, now);
  }
  return count == gateway::dds::ReaderBase::kBatch;
}

void ReleaseGate::take(const cansync_slave_ActualRelease& sample, const dds_sample_info_t& info,
                       SteadyTime now) {
  const bool known = sample.telegram == 1 || sample.telegram == 2;
  const unsigned channel = sample.telegram == 2 ? 1 : 0;
  if (info.valid_data && sample.given_up) {
    if (known && owners_[channel] == info.publication_handle) lost(channel, true, now);
    return;
  }
  if (info.instance_state != DDS_IST_ALIVE) {
    // Also with data: what a writer that has gone meanwhile had released is not sent any more.
    if (known) without_writer_[channel] = true;
    return;
  }
  if (!info.valid_data) return;
  if (const auto problem = problem_of(sample, info.source_timestamp)) {
    refuse(channel, *problem, now);
    return;
  }
  if (owners_[channel] != info.publication_handle) new_owner(channel, info.publication_handle, now);
  ReleaseOrder order;
  order.channel = channel_at(channel);
  order.valid = sample.valid;
  order.intervals = sample.wait_intervals == 0 ? 1 : sample.wait_intervals;
  std::copy(std::begin(sample.raw), std::end(sample.raw), order.values.begin());
  if (!exchange_.releases.try_push(order))
    refuse(channel, {gateway_CAUSE_QUEUE_FULL, "too many releases wait for the realtime thread; give fewer"},
           now);
}

gateway::dds::Problem ReleaseGate::problem_of(const cansync_slave_ActualRelease& sample,
                                              std::int64_t written) const {
  if (auto wrong = cansync_slave::dds::check(sample)) return wrong;
  if (read_only_) return Denial{gateway_CAUSE_READ_ONLY, "the daemon is read-only (access.read_only)"};
  if (gateway::dds::addressee(gateway::dds::daemon_of(sample), daemon_) !=
      gateway::dds::Addressee::this_daemon)
    return Denial{gateway_CAUSE_OTHER_DAEMON,
                  "meant for another start of the daemon: what was released before it is not sent; let the "
                  "program take up its telegrams"};
  const std::int64_t age = wall_clock_now() - written;
  const std::int64_t most = std::chrono::nanoseconds(kMaximumAge).count();
  if (age > most || age < -most)
    return Denial{gateway_CAUSE_STALE,
                  fmt::format("written {:.0f} ms ago; allowed: {} ms; check the load and the clocks",
                              static_cast<double>(age) / 1e6, kMaximumAge.count())};
  return std::nullopt;
}

void ReleaseGate::new_owner(unsigned channel, Writer writer, SteadyTime now) {
  const gateway::dds::WriterIdentity& who = writers_.identify(writer);
  const bool first = owners_[channel] == 0;
  EventText event{first ? gateway_SEVERITY_INFO : gateway_SEVERITY_WARNING, "actual_writer_began", -1,
                  fmt::format("{} (strength {}) releases the actual values of telegram {}{}", who.who,
                              who.strength, channel + 1, first ? "" : ", in place of " + names_[channel]),
                  std::nullopt};
  event.client = who.who;
  events_.publish(event, now);
  owners_[channel] = writer;
  names_[channel] = who.who;
}

void ReleaseGate::lost(unsigned channel, bool given_up, SteadyTime now) {
  if (owners_[channel] == 0) return;
  owners_[channel] = 0;
  ReleaseOrder withdraw;
  withdraw.channel = channel_at(channel);
  // Without room it ends by itself: a release waits for a bounded time.
  (void)exchange_.releases.try_push(withdraw);
  EventText event{given_up ? gateway_SEVERITY_INFO : gateway_SEVERITY_ERROR, "actual_writer_lost", -1,
                  fmt::format("{} {} telegram {}: nothing more is released", names_[channel],
                              given_up ? "gives up" : "has gone without giving up", channel + 1),
                  std::nullopt};
  event.client = names_[channel];
  events_.publish(event, now);
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
  return refusals_.next();
}

}  // namespace cansyncd
