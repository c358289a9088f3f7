#include "cansync_slave/dds/convert.h"

#include <algorithm>
#include <iterator>

#include "dds/bounded_text.h"

namespace cansync_slave::dds {
namespace {

/// The members that both kinds of samples have.
template <class Sample>
void fill(const ReceivedValues& received, Sample& sample) noexcept {
  std::copy(received.values.begin(), received.values.end(), std::begin(sample.raw));
  sample.arrived = received.arrived;
  sample.ever = received.ever;
  sample.words = received.words;
  std::copy(received.interval.begin(), received.interval.end(), std::begin(sample.interval));
  sample.receive_time = received.receive_time;
}

cansync_slave_SlaveCommandReply reply_to(const gateway::dds::RequestKey& key) noexcept {
  cansync_slave_SlaveCommandReply reply = {};
  std::copy(key.client.begin(), key.client.end(), std::begin(reply.client));
  reply.request = key.request;
  return reply;
}

}  // namespace

cansync_slave_ReferencesReceived references_received(const ReceivedValues& received,
                                                     std::uint64_t lost) noexcept {
  cansync_slave_ReferencesReceived sample = {};
  fill(received, sample);
  sample.lost = lost;
  return sample;
}

cansync_slave_MonitoredValues monitored_values(cansync::SlaveNumber slave, const ReceivedValues& received,
                                               const cansync::ProcessMapping& mapping) noexcept {
  cansync_slave_MonitoredValues sample = {};
  sample.slave = slave.value();
  fill(received, sample);
  put_registers(mapping, sample.mapping);
  return sample;
}

cansync_slave_SlaveCommandReply command_reply(const gateway::dds::RequestKey& key, gateway_ReplyCode code,
                                              const char* reason) noexcept {
  auto reply = reply_to(key);
  reply.code = code;
  gateway::dds::copy_text(reason, reply.reason);
  return reply;
}

cansync_slave_SlaveCommandReply command_refused(const gateway::dds::RequestKey& key,
                                                const gateway::dds::Denial& denial) noexcept {
  auto reply = reply_to(key);
  gateway::dds::refuse(reply, denial);
  return reply;
}

cansync::ProcessMapping mapping_of(std::span<const std::uint8_t, 8> bytes) noexcept {
  cansync::ProcessMapping mapping = {};
  for (unsigned i = 0; i < bytes.size(); ++i) {
    mapping[i / cansync::kWords].word[i % cansync::kWords] =
        cansync::from_register(bytes[i]).value_or(cansync::WordMapping{});
  }
  return mapping;
}

void put_registers(const cansync::ProcessMapping& mapping, std::uint8_t (&bytes)[8]) noexcept {
  for (unsigned i = 0; i < std::size(bytes); ++i)
    bytes[i] = cansync::to_register(mapping[i / cansync::kWords].word[i % cansync::kWords]);
}

}  // namespace cansync_slave::dds
