// How long an actual value takes from the bus to a DDS client's listener, and the same for a bare DDS writer.
//   dds_latency listen DOMAIN PARTITION SECONDS
//       prints one delay (ns) per sample, from receive_time
//   dds_latency write DOMAIN PARTITION SECONDS PER_SECOND
//       writes that many samples a second of 32 slaves
#include <dds/dds.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <string>
#include <vector>

#include "cansync.h"
#include "cansync/dds/topics.h"
#include "dds/endpoint.h"
#include "dds/participant.h"

namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

std::int64_t clock_now(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return now.tv_sec * kSecond + now.tv_nsec;
}

struct Delays {
  std::vector<std::int64_t> values;
};

void on_data(dds_entity_t reader, void* argument) {
  auto& delays = *static_cast<Delays*>(argument);
  const std::int64_t now = clock_now(CLOCK_REALTIME);
  void* samples[16] = {};
  dds_sample_info_t infos[16];
  const dds_return_t count = dds_take(reader, samples, infos, 16, 16);
  for (dds_return_t i = 0; i < count; ++i) {
    if (!infos[i].valid_data || delays.values.size() == delays.values.capacity()) continue;
    delays.values.push_back(now - static_cast<const cansync_ActualValues*>(samples[i])->receive_time);
  }
  if (count > 0) dds_return_loan(reader, samples, count);
}

int listen(const gateway::dds::Participant& participant, double seconds) {
  Delays delays;
  delays.values.reserve(1'000'000);
  gateway::dds::Reader<cansync_ActualValues> reader(participant);
  dds_listener_t* listener = dds_create_listener(&delays);
  dds_lset_data_available(listener, &on_data);
  dds_set_listener(reader.handle(), listener);
  dds_sleepfor(static_cast<dds_duration_t>(seconds * static_cast<double>(kSecond)));
  dds_set_listener(reader.handle(), nullptr);
  dds_delete_listener(listener);
  for (const std::int64_t delay : delays.values) std::printf("%lld\n", static_cast<long long>(delay));
  return delays.values.empty() ? 1 : 0;
}

int write(const gateway::dds::Participant& participant, double seconds, long per_second) {
  gateway::dds::Writer<cansync_ActualValues> writer(participant);
  const std::int64_t period = kSecond / per_second;
  const std::int64_t start = clock_now(CLOCK_MONOTONIC);
  const auto count = static_cast<std::int64_t>(seconds * static_cast<double>(per_second));
  for (std::int64_t i = 0; i < count; ++i) {
    const std::int64_t due = start + i * period;
    const timespec at{due / kSecond, due % kSecond};
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr);
    cansync_ActualValues sample = {};
    sample.slave = static_cast<std::uint8_t>(i % 32);
    std::strncpy(sample.slave_name, "slave", sizeof sample.slave_name - 1);
    sample.receive_time = clock_now(CLOCK_REALTIME);
    if (writer.write(sample) < 0) return 1;
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 5)
    return std::fprintf(stderr, "usage: %s listen|write DOMAIN PARTITION SECONDS [PER_SECOND]\n", argv[0]), 2;
  const bool listens = std::strcmp(argv[1], "listen") == 0;
  const gateway::dds::Participant participant({.domain = static_cast<std::uint32_t>(std::atoi(argv[2])),
                                               .partition = argv[3],
                                               .interface = "lo",
                                               .serves = !listens});
  const double seconds = std::atof(argv[4]);
  if (listens) return listen(participant, seconds);
  return write(participant, seconds, argc > 5 ? std::atol(argv[5]) : 1000);
}
