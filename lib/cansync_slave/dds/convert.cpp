#include "cansync_slave/dds/convert.h"

#include <algorithm>
#include <iterator>

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

void put_registers(const cansync::ProcessMapping& mapping, std::uint8_t (&bytes)[8]) noexcept {
  for (unsigned i = 0; i < std::size(bytes); ++i)
    bytes[i] = cansync::to_register(mapping[i / cansync::kWords].word[i % cansync::kWords]);
}

}  // namespace cansync_slave::dds
