#include "layer2/client/image_writer.h"

#include <algorithm>
#include <array>

#include "dds/bounded_text.h"
#include "dds/owner_seen.h"
#include "dds/security.h"

namespace layer2::client {
namespace {

template <class Sample>
std::string problem_of(gateway::dds::Writer<Sample>& writer, const Sample& sample) {
  const dds_return_t code = writer.write(sample);
  if (code == DDS_RETCODE_OK) return {};
  if (code == DDS_RETCODE_NOT_ALLOWED_BY_SECURITY)
    return gateway::dds::no_right(gateway::dds::topic_info<Sample>.name, "operator");
  return dds_strretcode(code);
}

gateway::dds::OwnerSeen seen(FrameClient& client, layer2_Ownership layer2_FrameStatus::*what) {
  const auto& status = client.take_status();
  if (!status) return {};
  const layer2_Ownership& owner = (*status).*what;
  return gateway::dds::owner_seen(owner.writer, owner.strength, owner.writer_guid);
}

gateway::dds::OwnerSeen image_owner(FrameClient& client) {
  return seen(client, &layer2_FrameStatus::image_ownership);
}

gateway::dds::OwnerSeen run_leader(FrameClient& client) {
  return seen(client, &layer2_FrameStatus::run_lead_ownership);
}

}  // namespace

ImageWriter::ImageWriter(FrameClient& client, std::int32_t strength)
    : client_(client),
      strength_(gateway::dds::strength_over(strength, {image_owner(client)})),
      writer_(client.participant(), strength_, nullptr, client.name()) {
  take_up();
}

ImageWriter::~ImageWriter() {
  give_up();
}

void ImageWriter::take_up() noexcept {
  daemon_ = gateway::dds::daemon_of(client_.gateway_status());
}

bool ImageWriter::daemon_restarted() const noexcept {
  return gateway::dds::daemon_of(client_.gateway_status()) != daemon_;
}

std::string ImageWriter::put(layer2_ImageOutputs& sample) {
  client_.wait_for_match(writer_);
  gateway::dds::set_daemon(daemon_, sample);
  gateway::dds::set_writer(writer_, sample);
  return problem_of(writer_, sample);
}

std::string ImageWriter::write(std::uint16_t address, std::span<const std::uint8_t> bytes) {
  if (address + bytes.size() > image_.size())
    return "address and bytes: end after the image; allowed 0..1024 together";
  if (std::string had =
          gateway::dds::had_by_another("the image that is sent", image_owner(client_), writer_, strength_);
      !had.empty())
    return had;
  std::copy(bytes.begin(), bytes.end(), image_.begin() + address);
  begin_ = end_ == 0 ? address : std::min<std::size_t>(begin_, address);
  end_ = std::max(end_, address + bytes.size());
  layer2_ImageOutputs sample = {};
  sample.address = static_cast<std::uint16_t>(begin_);
  auto copy = image_;  // DDS's types may change a sample's bytes
  sample.data._buffer = copy.data() + begin_;
  sample.data._length = sample.data._maximum = static_cast<std::uint32_t>(end_ - begin_);
  return put(sample);
}

void ImageWriter::give_up() {
  if (end_ == 0) return;
  layer2_ImageOutputs sample = {};
  sample.given_up = true;
  (void)put(sample);
  (void)writer_.unregister(sample);
  (void)dds_wait_for_acks(writer_.handle(), DDS_MSECS(500));
  image_.fill(0);
  begin_ = end_ = 0;
}

RunLead::RunLead(FrameClient& client, std::string_view client_name, std::int32_t strength)
    : client_(client),
      name_(client_name),
      strength_(gateway::dds::strength_over(strength, {run_leader(client)})),
      writer_(client.participant(), strength_, nullptr, client_name) {}

RunLead::~RunLead() {
  (void)say(false);
  (void)dds_wait_for_acks(writer_.handle(), DDS_MSECS(500));
}

std::string RunLead::say(bool run) {
  client_.wait_for_match(writer_);
  if (std::string had = gateway::dds::had_by_another("run and stop", run_leader(client_), writer_, strength_);
      !had.empty())
    return had;
  layer2_RunLead sample = {};
  gateway::dds::set_writer(writer_, sample);
  gateway::dds::copy_text(name_, sample.client_name);
  sample.run = run;
  gateway::dds::set_daemon(gateway::dds::daemon_of(client_.gateway_status()), sample);
  return problem_of(writer_, sample);
}

}  // namespace layer2::client
