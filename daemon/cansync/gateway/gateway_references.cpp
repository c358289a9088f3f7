#include "daemon/cansync/gateway/gateway_references.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "cansync/dds/convert.h"
#include "daemon/cansync/requests/access.h"
#include "daemon/cansync/texts/limit_text.h"
#include "text/counts.h"

namespace cansyncd {

namespace dds = cansync::dds;

ReferenceInput::ReferenceInput(const dds::Participant& participant, dds::DataSignal& signal,
                               EventPublisher& events, const Config& config, const DaemonIdentity& daemon,
                               Exchange& exchange)
    : reader_(participant, signal),
      events_(events),
      exchange_(exchange),
      limits_(dds::limits_of(config.master)),
      gate_(daemon, config, *this, read_only_refusal_of_references(config)) {}

bool ReferenceInput::take_samples(SteadyTime now) {
  // A key that is no telegram has no owner.
  const auto number = [](const cansync_ReferenceValues& sample) { return sample.telegram - 1u; };
  const auto gives_up = [](const cansync_ReferenceValues& sample) { return sample.given_up; };
  const bool more = reader_.take(
      number, gives_up,
      [&](const cansync_ReferenceValues& sample, const dds_sample_info_t& info) { take(sample, info, now); });
  for (unsigned channel = 0; channel < cansync::kChannels; ++channel) {
    if (reader_.lost(channel, gate_.arbiter(channel))) gate_.lost(channel, wall_clock_now(), now);
  }
  reader_.tell_dropped(events_, now);
  return more;
}

void ReferenceInput::take(const cansync_ReferenceValues& sample, const dds_sample_info_t& info,
                          SteadyTime now) {
  ReferenceSample taken;
  taken.writer = info.publication_handle;
  taken.key = OwnedReader<cansync_ReferenceValues>::key_of(sample);
  taken.telegram = sample.telegram;
  taken.given_up = sample.given_up;
  taken.written = info.source_timestamp;
  std::copy(std::begin(sample.daemon), std::end(sample.daemon), taken.daemon.begin());
  taken.problem = dds::check(sample, limits_);
  taken.update = dds::to_core(sample);
  gate_.take(taken, wall_clock_now(), now);
}

std::string ReferenceInput::hand_on(const Request& request) {
  if (exchange_.requests.try_push(request)) return {};
  return fmt::format("request queue full: {} for the realtime thread, at most {} are allowed",
                     text::counted(exchange_.requests.size(), "request waits", "requests wait"),
                     exchange_.requests.capacity());
}

void ReferenceInput::refused(const ReferenceRefused& report, const Config& config,
                             const RefusalContext& context, SteadyTime now) {
  const unsigned channel = cansync::index(report.channel);
  if (report.refusal == cansync::Refusal::beyond_limit) {
    gate_.refused_for_limit(channel, limit_denial(report.beyond, config), report.when, now);
    return;
  }
  gate_.refused(channel, denial_of(report.refusal, gate_.newest(channel), config, context), report.when, now);
}

}  // namespace cansyncd
