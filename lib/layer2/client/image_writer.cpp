#include "layer2/client/image_writer.h"

#include <algorithm>
#include <array>

#include "dds/bounded_text.h"
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

}  // namespace

ImageWriter::ImageWriter(FrameClient& client, std::int32_t strength)
    : client_(client), writer_(client.participant(), strength, nullptr, client.name()) {
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
  return problem_of(writer_, sample);
}

std::string ImageWriter::write(std::uint16_t address, std::span<const std::uint8_t> bytes) {
  layer2_ImageOutputs sample = {};
  sample.address = address;
  // A sample's bytes may be changed by DDS's types.
  std::array<std::uint8_t, sizeof(layer2_ProcessImage::outputs)> copy = {};
  const std::size_t size = std::min(bytes.size(), copy.size());
  if (size != bytes.size()) return "more bytes than the image has";
  std::copy(bytes.begin(), bytes.end(), copy.begin());
  sample.data._buffer = copy.data();
  sample.data._length = sample.data._maximum = static_cast<std::uint32_t>(size);
  written_ = true;
  return put(sample);
}

void ImageWriter::give_up() {
  if (!written_) return;
  layer2_ImageOutputs sample = {};
  sample.given_up = true;
  (void)put(sample);
  (void)writer_.unregister(sample);
  (void)dds_wait_for_acks(writer_.handle(), DDS_MSECS(500));
  written_ = false;
}

RunLead::RunLead(FrameClient& client, std::string_view client_name, std::int32_t strength)
    : client_(client), name_(client_name), writer_(client.participant(), strength, nullptr, client_name) {}

RunLead::~RunLead() {
  (void)say(false);
  (void)dds_wait_for_acks(writer_.handle(), DDS_MSECS(500));
}

std::string RunLead::say(bool run) {
  client_.wait_for_match(writer_);
  layer2_RunLead sample = {};
  gateway::dds::copy_text(name_, sample.client_name);
  sample.run = run;
  gateway::dds::set_daemon(gateway::dds::daemon_of(client_.gateway_status()), sample);
  return problem_of(writer_, sample);
}

}  // namespace layer2::client
