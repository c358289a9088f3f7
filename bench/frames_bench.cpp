// General frames at full bus load: what a client records, and the yardstick, a bridge of 30 lines.
//   frames_bench record DOMAIN BUS SECONDS   a client of the daemon
//   frames_bench listen DOMAIN BUS SECONDS   a reader of the bridge
//   frames_bench bridge DOMAIN BUS SECONDS   the bridge: a simulated bus of 1 Mbit/s, each look as it is
// Each prints one JSON object; times in ns.
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "dds/endpoint.h"
#include "dds/participant.h"
#include "dds/signal.h"
#include "layer2.h"
#include "layer2/client/frame_client.h"
#include "layer2/dds/convert.h"
#include "layer2/dds/topics.h"
#include "layer2/sim/frame_node.h"
#include "sim/line.h"

namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr unsigned kNodes = 32;
constexpr std::uint32_t kFirstIdentifier = 0x100;

/// What came: how much, in which order, and with which gaps.
class Recording {
 public:
  void take(const layer2_FrameBatch& batch) {
    if (number_ != 0) missed_ += batch.number - number_ - 1;
    if (number_ == 0) lost_at_start_ = batch.lost;
    number_ = batch.number;
    lost_ = batch.lost;
    for (std::uint32_t i = 0; i < batch.frames._length; ++i) {
      const std::int64_t at = batch.frames._buffer[i].receive_time;
      if (frames_++ != 0) {
        if (at <= last_) ++not_rising_;
        largest_gap_ = std::max(largest_gap_, at - last_);
        if (at - last_ > kTwoFrames) ++gaps_;
      } else {
        first_ = at;
      }
      last_ = at;
    }
  }

  void print() const {
    std::printf(
        "{\"frames\": %llu, \"missed_batches\": %llu, \"lost\": %llu, \"not_rising\": %llu, \"gaps\": %llu, "
        "\"largest_gap\": %lld, \"length\": %lld}\n",
        static_cast<unsigned long long>(frames_), static_cast<unsigned long long>(missed_),
        static_cast<unsigned long long>(lost_ - lost_at_start_), static_cast<unsigned long long>(not_rising_),
        static_cast<unsigned long long>(gaps_), static_cast<long long>(largest_gap_),
        static_cast<long long>(last_ - first_));
  }

 private:
  /// Two of the shortest frames at 1 Mbit/s have 94 bits: on a bus that is never free no more lies between
  /// two, unless one is missing.
  static constexpr std::int64_t kTwoFrames = 94'000;

  std::uint64_t frames_ = 0;
  std::uint64_t number_ = 0;
  std::uint64_t missed_ = 0;
  std::uint64_t lost_ = 0;
  std::uint64_t lost_at_start_ = 0;
  std::uint64_t not_rising_ = 0;
  std::uint64_t gaps_ = 0;
  std::int64_t largest_gap_ = 0;
  std::int64_t first_ = 0;
  std::int64_t last_ = 0;
};

int record(std::uint32_t domain, const char* bus, double seconds) {
  layer2::client::Options options;
  options.domain = domain;
  options.bus = bus;
  options.wait = milliseconds(10000);
  layer2::client::FrameClient client(options);
  Recording recording;
  const auto end = steady_clock::now() + std::chrono::duration<double>(seconds);
  while (steady_clock::now() < end) {
    if (!client.receive(milliseconds(100), [&](const layer2_FrameBatch& batch) { recording.take(batch); }))
      return 1;
  }
  recording.print();
  return 0;
}

int listen(std::uint32_t domain, const char* bus, double seconds) {
  const gateway::dds::Participant participant({domain, bus, "lo", ""});
  gateway::dds::DataSignal signal;
  gateway::dds::Reader<layer2_FrameBatch> reader(participant, &signal);
  Recording recording;
  const auto end = steady_clock::now() + std::chrono::duration<double>(seconds);
  while (steady_clock::now() < end) {
    signal.clear();
    if (reader.take([&](const layer2_FrameBatch& batch) { recording.take(batch); }) == 0)
      (void)signal.wait(100);
  }
  recording.print();
  return 0;
}

int bridge(std::uint32_t domain, const char* bus, double seconds) {
  std::vector<std::unique_ptr<sim::Node>> nodes;
  for (unsigned n = 0; n < kNodes; ++n) {
    sim::FrameNodeSettings settings;
    settings.periodic = can::Frame{.id = kFirstIdentifier + n};
    settings.period = milliseconds(1);
    nodes.push_back(std::make_unique<sim::FrameNode>(std::move(settings)));
  }
  sim::LineSettings settings;
  settings.clock = sim::ClockKind::real_time;
  sim::Line line(settings, std::move(nodes));
  const gateway::dds::Participant participant(
      {.domain = domain, .partition = bus, .interface = "lo", .serves = true});
  gateway::dds::Writer<layer2_FrameBatch> writer(participant);
  const can::Time end =
      line.now() + std::chrono::duration_cast<can::Time>(std::chrono::duration<double>(seconds));
  layer2_FrameBatch batch = {};
  layer2_ReceivedFrame frames[layer2_BATCH] = {};
  batch.frames = {layer2_BATCH, 0, frames, false};
  std::uint64_t count = 0;
  while (line.now() < end) {
    (void)line.wait_until(end);
    batch.frames._length = 0;
    for (can::ReceivedFrame r; batch.frames._length < layer2_BATCH && line.receive(r);)
      frames[batch.frames._length++] = layer2::dds::received_frame(r.frame, r.end.count(), 0, false);
    if (batch.frames._length == 0) continue;
    ++batch.number;
    count += batch.frames._length;
    if (writer.write(batch) != DDS_RETCODE_OK) return 1;
  }
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  const auto nanoseconds = [](const timeval& t) { return t.tv_sec * 1'000'000'000LL + t.tv_usec * 1000LL; };
  std::printf("{\"frames\": %llu, \"batches\": %llu, \"processor\": %lld}\n",
              static_cast<unsigned long long>(count), static_cast<unsigned long long>(batch.number),
              nanoseconds(used.ru_utime) + nanoseconds(used.ru_stime));
  return 0;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 5)
    return std::fprintf(stderr, "usage: %s record|listen|bridge DOMAIN BUS SECONDS\n", argv[0]), 2;
  const std::string_view role = argv[1];
  const auto domain = static_cast<std::uint32_t>(std::strtoul(argv[2], nullptr, 10));
  const double seconds = std::strtod(argv[4], nullptr);
  if (role == "record") return record(domain, argv[3], seconds);
  return role == "bridge" ? bridge(domain, argv[3], seconds) : listen(domain, argv[3], seconds);
} catch (const std::exception& error) {
  return std::fprintf(stderr, "%s\n", error.what()), 1;
}
