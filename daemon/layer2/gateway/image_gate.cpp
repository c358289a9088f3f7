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
    : writer_(participant, signal), events_(events), daemon_(daemon), exchange_(exchange) {}

bool ImageGate::take_samples(SteadyTime now) {
  const bool more = writer_.take(
      [&](const layer2_ImageOutputs& sample, dds_instance_handle_t writer) { take(sample, writer, now); });
  if (writer_.gone()) lost(now);
  if (changed_) exchange_.outputs.write(image_);
  changed_ = false;
  return more;
}

void ImageGate::take(const layer2_ImageOutputs& sample, dds_instance_handle_t writer, SteadyTime now) {
  if (sample.given_up) {
    if (writer_.owner() != writer) return;
    EventText event{gateway_SEVERITY_INFO, "image_given_up", -1,
                    fmt::format("{} gives the image up, which stays as it is", writer_.name()), std::nullopt};
    event.client = writer_.name();
    events_.publish(event, now);
    writer_.own(0);
    return;
  }
  if (const auto problem = problem_of(sample)) {
    if (refusals_.add(1, now)) {
      events_.publish({gateway_SEVERITY_WARNING, "image_refused", -1,
                       fmt::format("bytes for the image are not taken: {}", problem->reason), std::nullopt},
                      now);
    }
    return;
  }
  if (writer_.owner() != writer) take_over(writer, now);
  std::copy_n(sample.data._buffer, sample.data._length, image_.bytes.begin() + sample.address);
  changed_ = true;
}

gateway::dds::Problem ImageGate::problem_of(const layer2_ImageOutputs& sample) const {
  if (gateway::dds::addressee(gateway::dds::daemon_of(sample), daemon_) !=
      gateway::dds::Addressee::this_daemon)
    return Denial{gateway_CAUSE_OTHER_DAEMON, "meant for another start of the daemon"};
  if (rules_.read_only) return Denial{gateway_CAUSE_READ_ONLY, "the daemon is read-only (access.read_only)"};
  if (!rules_.mapped) {
    return Denial{gateway_CAUSE_MAPPING, "there is no process image; give the daemon [[mapped]] sections"};
  }
  if (sample.address + std::size_t{sample.data._length} <= image_.bytes.size()) return std::nullopt;
  return Denial{gateway_CAUSE_ADDRESS,
                fmt::format("address {} and {}: end after the image; allowed: 0..{} together", sample.address,
                            text::counted(sample.data._length, "byte"), image_.bytes.size())};
}

void ImageGate::take_over(dds_instance_handle_t writer, SteadyTime now) {
  const std::string before = writer_.name();
  writer_.own(writer);
  const bool first = before.empty();
  EventText event{
      first ? gateway_SEVERITY_INFO : gateway_SEVERITY_WARNING, "image_writer_began", -1,
      fmt::format("{} owns the image that is sent{}", writer_.name(), first ? "" : ", in place of " + before),
      std::nullopt};
  event.client = writer_.name();
  events_.publish(event, now);
  image_.sending = true;
  changed_ = true;
}

void ImageGate::lost(SteadyTime now) {
  EventText event{
      gateway_SEVERITY_ERROR, "image_writer_lost", -1,
      fmt::format("{} has gone without giving the image up: {}", writer_.name(), text_of(rules_.lost)),
      std::nullopt};
  event.client = writer_.name();
  events_.publish(event, now);
  writer_.own(0);
  if (rules_.lost == WriterLost::zero) image_.bytes.fill(0);
  if (rules_.lost == WriterLost::stop_sending) image_.sending = false;
  changed_ = true;
}

bool ImageGate::write(std::uint16_t address, std::span<const std::uint8_t> bytes) {
  if (!rules_.mapped || writer_.owner() != 0 || address + bytes.size() > image_.bytes.size()) return false;
  std::copy(bytes.begin(), bytes.end(), image_.bytes.begin() + address);
  image_.sending = true;
  exchange_.outputs.write(image_);
  return true;
}

std::optional<SteadyTime> ImageGate::tick(SteadyTime now) {
  (void)refusals_.take_over(now);
  return refusals_.next();
}

}  // namespace cansyncd
