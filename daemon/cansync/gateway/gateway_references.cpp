#include "daemon/cansync/gateway/gateway_references.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "cansync/dds/convert.h"
#include "daemon/cansync/requests/access.h"
#include "text/counts.h"

namespace cansyncd {

namespace dds = cansync::dds;

ReferenceInput::ReferenceInput(const dds::Participant& participant, dds::DataSignal& signal,
                               EventPublisher& events, const Config& config, const DaemonIdentity& daemon,
                               Exchange& exchange)
    : reader_(participant, &signal),
      events_(events),
      exchange_(exchange),
      limits_(dds::limits_of(config.master)),
      writers_(participant, reader_.handle()),
      gate_(daemon, config, *this, read_only_refusal_of_references(config)) {}

bool ReferenceInput::take_samples(SteadyTime now) {
  without_writer_ = {};
  const auto count = reader_.take_batch(
      [&](const cansync_ReferenceValues& sample, const dds_sample_info_t& info) { take(sample, info, now); });
  for (unsigned channel = 0; channel < cansync::kChannels; ++channel) {
    if (without_writer_[channel]) gate_.lost(channel, now);
  }
  look_for_owners(now);
  return count == dds::ReaderBase::kBatch;
}

void ReferenceInput::take(const cansync_ReferenceValues& sample, const dds_sample_info_t& info,
                          SteadyTime now) {
  const bool gives_up = info.valid_data && sample.given_up;
  if (info.instance_state != DDS_IST_ALIVE && !gives_up) {
    // Also with data: values whose writer has gone meanwhile are not released any more. Told after the batch,
    // because the sample that gives the telegram up may still come.
    if (sample.telegram == 1 || sample.telegram == 2) without_writer_[sample.telegram - 1u] = true;
    return;
  }
  if (!info.valid_data) return;
  ReferenceSample taken;
  taken.writer = info.publication_handle;
  taken.telegram = sample.telegram;
  taken.given_up = sample.given_up;
  taken.written = info.source_timestamp;
  std::copy(std::begin(sample.daemon), std::end(sample.daemon), taken.daemon.begin());
  taken.problem = dds::check(sample, limits_);
  taken.update = dds::to_core(sample);
  gate_.take(taken, wall_clock_now(), now);
}

void ReferenceInput::look_for_owners(SteadyTime now) {
  if (!writers_.look()) return;
  for (unsigned channel = 0; channel < cansync::kChannels; ++channel) {
    const WriterHandle owner = gate_.owner(channel);
    if (owner != 0 && writers_.gone(owner)) gate_.lost(channel, now);
  }
}

std::string ReferenceInput::hand_on(const Request& request) {
  if (exchange_.requests.try_push(request)) return {};
  return fmt::format("request queue full: {} for the realtime thread, at most {} are allowed",
                     text::counted(exchange_.requests.size(), "request waits", "requests wait"),
                     exchange_.requests.capacity());
}

ReferenceSurroundings::Writer ReferenceInput::identify(WriterHandle writer) {
  const dds::WriterIdentity& identity = writers_.identify(writer);
  return {identity.who, identity.strength};
}

void ReferenceInput::refused(const ReferenceRefused& report, const Config& config,
                             const RefusalContext& context, SteadyTime now) {
  const unsigned channel = cansync::index(report.channel);
  gate_.refused(channel, denial_of(report.refusal, gate_.newest(channel), config, context), report.when, now);
}

}  // namespace cansyncd
