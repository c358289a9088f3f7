#include "daemon/layer2/gateway/image_gate.h"

#include <fmt/format.h>

#include <algorithm>

#include "dds/daemon_identity.h"
#include "layer2/dds/topics.h"
#include "text/counts.h"

namespace cansyncd {
namespace {

using gateway::dds::Denial;

std::string_view text_of(WriterLost reaction) {
  switch (reaction) {
    case WriterLost::hold:
      return "the image is sent on as it is";
    case WriterLost::zero:
      return "the image is all 0 now";
    case WriterLost::stop_sending:
      break;
  }
  return "the image is not sent any more";
}

}  // namespace

ImageGate::ImageGate(const gateway::dds::Participant& participant, gateway::dds::DataSignal& signal,
                     EventPublisher& events, const DaemonIdentity& daemon, Layer2Exchange& exchange)
    : reader_(participant, signal), events_(events), daemon_(daemon), exchange_(exchange) {}

bool ImageGate::take_samples(SteadyTime now) {
  const bool more = reader_.take([](const layer2_ImageOutputs& /*sample*/) { return 0u; },
                                 [](const layer2_ImageOutputs& sample) { return sample.given_up; },
                                 [&](const layer2_ImageOutputs& sample, const dds_sample_info_t& info) {
                                   take(sample, info.publication_handle, now);
                                 });
  if (reader_.lost(0, arbiter_))
    gone(gateway_SEVERITY_ERROR, "image_writer_lost", "has gone without giving the image up", now);
  reader_.tell_dropped(events_, now);
  if (changed_) exchange_.outputs.write(image_);
  changed_ = false;
  return more;
}

void ImageGate::take(const layer2_ImageOutputs& sample, WriterHandle writer, SteadyTime now) {
  if (sample.given_up) {
    arbiter_.forget(writer);
    if (arbiter_.owner().handle != writer) return;
    return gone(gateway_SEVERITY_INFO, "image_given_up", "gives the image up", now);
  }
  if (const auto problem = problem_of(sample)) {
    if (refusals_.add(1, now)) {
      events_.publish({gateway_SEVERITY_WARNING, "image_refused", -1,
                       fmt::format("bytes for the image are not taken: {}", problem->reason), std::nullopt},
                      now);
    }
    return;
  }
  const TopicWriter from = reader_.writer_of(sample, writer);
  const WriterArbiter::Claim claim = arbiter_.claim(writer, from.identity.strength);
  if (claim == WriterArbiter::Claim::waits) return tell_waiting(events_, arbiter_, from, now);
  if (claim != WriterArbiter::Claim::keeps) give_to(from, now);
  std::copy_n(sample.data._buffer, sample.data._length, image_.bytes.begin() + sample.address);
  image_.sending = true;
  changed_ = true;
}

gateway::dds::Problem ImageGate::problem_of(const layer2_ImageOutputs& sample) const {
  if (gateway::dds::addressee(gateway::dds::daemon_of(sample), daemon_) !=
      gateway::dds::Addressee::this_daemon)
    return Denial{gateway_CAUSE_OTHER_DAEMON,
                  "meant for another start of the daemon; write with GatewayStatus.daemon of this one"};
  if (rules_.read_only)
    return Denial{
        gateway_CAUSE_READ_ONLY,
        "the daemon is read-only; set access.read_only to false in the configuration and reload the daemon"};
  if (!rules_.mapped) {
    return Denial{gateway_CAUSE_MAPPING, "there is no process image; give the daemon [[mapped]] sections"};
  }
  if (sample.address + std::size_t{sample.data._length} <= image_.bytes.size()) return std::nullopt;
  return Denial{gateway_CAUSE_ADDRESS,
                fmt::format("address {} and {}: end after the image; allowed: 0..{} together", sample.address,
                            text::counted(sample.data._length, "byte"), image_.bytes.size())};
}

void ImageGate::give_to(const TopicWriter& writer, SteadyTime now) {
  const std::string before = owner();
  arbiter_.give(writer);
  const bool first = before.empty();
  EventText event{
      first ? gateway_SEVERITY_INFO : gateway_SEVERITY_WARNING, "image_writer_began", -1,
      fmt::format("{} owns the image that is sent{}", owner(), first ? "" : ", in place of " + before),
      std::nullopt};
  event.client = owner();
  events_.publish(event, now);
  image_.bytes.fill(0);
}

/// Whoever has given the image gives it no more.
void ImageGate::gone(gateway_EventSeverity severity, EventCode code, std::string_view how, SteadyTime now) {
  const std::string who = owner().empty() ? "who wrote it by request" : owner();
  EventText event{severity, code, -1, fmt::format("{} {}: {}", who, how, text_of(rules_.lost)), std::nullopt};
  event.client = owner();
  events_.publish(event, now);
  arbiter_.free();
  if (rules_.lost == WriterLost::zero) image_.bytes.fill(0);
  if (rules_.lost == WriterLost::stop_sending) image_.sending = false;
  changed_ = true;
}

void ImageGate::set_rules(const Rules& rules, SteadyTime now) {
  const bool shut = rules.read_only && !rules_.read_only;
  rules_ = rules;
  if (!shut || !(image_.sending || arbiter_.owner().handle != 0)) return;
  gone(gateway_SEVERITY_INFO, "image_writer_lost", "may not write while access.read_only is set", now);
  exchange_.outputs.write(image_);
  changed_ = false;
}

void ImageGate::begin_anew(SteadyTime now) {
  if (image_.sending && rules_.mapped) {
    const std::string who = owner().empty() ? "a program or a request" : owner();
    EventText event{
        gateway_SEVERITY_WARNING, "image_begins_anew", -1,
        fmt::format("the mapping was changed, and its image is all 0: nothing is sent until {} writes it "
                    "anew",
                    who),
        std::nullopt};
    event.client = owner();
    events_.publish(event, now);
  }
  image_.bytes.fill(0);
  image_.sending = false;
  ++image_.table;
}

std::optional<std::uint32_t> ImageGate::write(std::uint16_t address, std::span<const std::uint8_t> bytes) {
  if (!rules_.mapped || rules_.read_only || arbiter_.owner().handle != 0 ||
      address + bytes.size() > image_.bytes.size())
    return std::nullopt;
  if (!image_.sending) image_.bytes.fill(0);
  std::copy(bytes.begin(), bytes.end(), image_.bytes.begin() + address);
  image_.sending = true;
  exchange_.outputs.write(image_);
  return image_.table;
}

std::optional<SteadyTime> ImageGate::tick(SteadyTime now) {
  (void)refusals_.take_over(now);
  return refusals_.next();
}

}  // namespace cansyncd
