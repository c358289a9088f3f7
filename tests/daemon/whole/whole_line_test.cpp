// The daemon's realtime loop, the simulated bus and 32 drives together, in virtual time.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <variant>

#include "can/frame_length.h"
#include "cansync/telegram/telegram.h"
#include "support/virtual_line.h"

namespace cansyncd::test {
namespace {

using namespace cansync;
using support::drives_for;
using support::line_settings;
using support::VirtualLine;

SlaveNumber slave(unsigned n) {
  return *SlaveNumber::from(n);
}

/// Eight data bytes that make the frame with this identifier as long as patterns of period 8 and the best of
/// 4096 arbitrary ones can.
can::Frame longest_frame(std::uint32_t id, std::uint8_t fixed_bytes, can::Frame best) {
  best.id = id;
  best.dlc = 8;
  std::uint32_t seed = 12345;
  can::Frame candidate = best;
  for (unsigned i = 0; i < 4096; ++i) {
    seed = seed * 1664525u + 1013904223u;
    // Runs of four equal bits each earn a stuff bit; the start of the pattern is what varies.
    const std::uint8_t pattern = static_cast<std::uint8_t>(i < 256 ? i : seed >> 24);
    for (unsigned byte = fixed_bytes; byte < 8; ++byte) {
      const bool mixed = i >= 256 && ((seed >> byte) & 1u) != 0;
      candidate.data[byte] = mixed ? static_cast<std::uint8_t>(~pattern) : pattern;
    }
    if (can::frame_bits(candidate) > can::frame_bits(best)) best = candidate;
  }
  return best;
}

/// The longest reference telegram's values: doublewords 0 and 1 (4 and 5), as the default mapping sends them.
ReferenceUpdate longest_references(Channel channel, SlaveNumber polled) {
  const std::uint32_t base = channel == Channel::one ? identifier::reference_one : identifier::reference_two;
  const can::Frame frame = longest_frame(base + polled.value(), 0, {});
  ReferenceUpdate update;
  update.channel = channel;
  update.value = {load_doubleword(frame.data.data()), load_doubleword(frame.data.data() + 4)};
  update.valid_mask = 3;
  return update;
}

/// The longest parameter command: a doubleword write, with the value and sub-slave address that stuff it
/// most.
ParameterRequest longest_write(JobId id, SlaveNumber target) {
  const can::Frame frame = longest_frame(identifier::command + target.value(), 2, {.data = {0x70, 0x07}});
  ParameterRequest request;
  request.id = id;
  request.write = true;
  request.slave = target;
  request.sub_slave = {load_word(frame.data.data() + 6)};
  request.number = *ParameterNumber::from(7);
  request.format = ParameterFormat::doubleword;
  request.value = load_doubleword(frame.data.data() + 2);
  return request;
}

/// A slave whose every answer is as long as a frame can be: eight bytes, stuffed as far as the search finds.
/// It answers parameter commands busy, so that the master repeats them for ever.
class LongestNode final : public sim::Node {
 public:
  LongestNode(SlaveNumber number, BitRate rate) : number_(number), delay_(20 * slot_times(rate).bit_time()) {
    actual_[0] = longest_frame(identifier::actual_one + number.value(), 0, {});
    actual_[1] = longest_frame(identifier::actual_two + number.value(), 0, {});
    busy_ = longest_frame(identifier::response + number.value(), 2, {.data = {0x40, 0x07}});
    status_ = can::Frame{
        .id = identifier::response + number.value(), .dlc = 6, .data = {0x01, 0x2D, 0x00, 0x80, 0, 0}};
  }

  sim::NodeNumber node_number() const noexcept override { return number_.value(); }
  bool accepts(const can::Frame&) const noexcept override { return true; }
  void on_sync(can::Time) noexcept override {}
  std::optional<sim::Transmission> on_frame(const can::Frame& frame, can::Time end) noexcept override {
    const Decoded decoded = decode(frame);
    const auto* telegram = std::get_if<Telegram>(&decoded);
    if (telegram == nullptr) return std::nullopt;
    if (const auto* reference = std::get_if<ReferenceTelegram>(telegram)) {
      if (reference->polled != number_.value()) return std::nullopt;
      return sim::Transmission{actual_[index(reference->channel)], end + delay_};
    }
    const auto* command = std::get_if<ParameterCommand>(telegram);
    if (command == nullptr || command->slave != number_) return std::nullopt;
    return sim::Transmission{command->number.value() == 301 ? status_ : busy_, end + delay_};
  }

 private:
  SlaveNumber number_;
  can::Time delay_;
  std::array<can::Frame, 2> actual_;
  can::Frame busy_;
  can::Frame status_;
};

/// Latest start of the telegram with this identifier, after SYNC, in active operation.
Duration latest_start(const SlotTimes& times, std::uint32_t id) {
  switch (id & 0x780) {
    case identifier::reference_one:
      return times.reference_one;
    case identifier::reference_two:
      return times.reference_two;
    case identifier::actual_one:
      return times.actual_one;
    case identifier::actual_two:
      return times.actual_two;
    case identifier::response:
      return times.response;
    default:
      return times.command;
  }
}

/// What the slot check saw of each channel.
struct Seen {
  unsigned frames = 0;
  unsigned late = 0;
  unsigned longest = 0;
  Duration latest{0};
};

/// Checks the start of every frame after `from` edges; returns what was seen by channel.
std::map<std::uint32_t, Seen> watch_slots(VirtualLine& line, const SlotTimes& times, std::uint64_t from,
                                          std::uint64_t edges) {
  std::map<std::uint32_t, Seen> seen;
  line.on_frame = [&](const sim::TracedFrame& traced, can::Time since) {
    if (line.line().intervals() < from) return;
    Seen& channel = seen[traced.frame.id & 0x780];
    ++channel.frames;
    channel.longest = std::max(channel.longest, can::frame_bits(traced.frame));
    channel.latest = std::max(channel.latest, Duration(since));
    if (since > latest_start(times, traced.frame.id)) ++channel.late;
  };
  line.run(edges);
  return seen;
}

class Slots : public testing::TestWithParam<BitRate> {};

TEST_P(Slots, NoTelegramStartsAfterItsSlotWithTheLongestTelegramsAndEveryChannelUsed) {
  constexpr std::uint64_t kSetUp = 100;
  constexpr std::uint64_t kIntervals = 10'000;
  const SlotTimes& times = slot_times(GetParam());
  MasterSettings settings = line_settings(GetParam());
  settings.command_channel.parameter_monitoring = std::chrono::hours(1);
  std::vector<std::unique_ptr<sim::Node>> nodes;
  for (unsigned i = 0; i < kSlaves; ++i) nodes.push_back(std::make_unique<LongestNode>(slave(i), GetParam()));
  VirtualLine line(settings, std::move(nodes));

  std::array<std::array<ReferenceUpdate, kChannels>, kSlaves> references;
  for (unsigned i = 0; i < kSlaves; ++i) {
    references[i] = {longest_references(Channel::one, slave(i)), longest_references(Channel::two, slave(i))};
  }
  line.on_edge = [&](std::uint64_t edge) {
    for (const ReferenceUpdate& update : references[edge % kSlaves]) {
      static_cast<void>(line.exchange().requests.try_push(update));
    }
    if (edge != kSetUp - 1) return;
    for (unsigned i = 0; i < kSlaves; ++i) {
      ASSERT_TRUE(line.exchange().requests.try_push(longest_write(i + 1, slave(i))));
    }
  };
  auto seen = watch_slots(line, times, kSetUp, kSetUp + kIntervals);

  for (const std::uint32_t channel :
       {identifier::reference_one, identifier::actual_one, identifier::reference_two, identifier::actual_two,
        identifier::command, identifier::response}) {
    EXPECT_EQ(seen[channel].late, 0u)
        << std::hex << channel << " latest " << std::dec << seen[channel].latest.count();
    EXPECT_GE(seen[channel].frames, kIntervals - 5) << std::hex << channel;
    EXPECT_GE(seen[channel].longest, 127u) << std::hex << channel;
    EXPECT_LE(seen[channel].longest, can::worst_case_bits(8));
  }
  EXPECT_EQ(line.snapshot().counters.left_out, 0u);
  EXPECT_EQ(line.snapshot().missed_syncs, 0u);
}

TEST_P(Slots, NoTelegramOf32DrivesStartsAfterItsSlotWithJobsOfEveryKind) {
  constexpr std::uint64_t kSetUp = 400;
  const SlotTimes& times = slot_times(GetParam());
  const MasterSettings settings = line_settings(GetParam());
  VirtualLine line(settings, drives_for(settings));
  std::vector<std::uint8_t> data(20'000, 0x3C);
  line.on_edge = [&](std::uint64_t edge) {
    line.give_references(static_cast<std::uint32_t>(edge * 100));
    if (edge < kSetUp) return;
    auto& requests = line.exchange().requests;
    const JobId id = edge * 10;
    const SlaveNumber target = slave(static_cast<unsigned>(edge % kSlaves));
    if (edge == kSetUp) {
      ASSERT_TRUE(requests.try_push(TransferRequest{.id = 1,
                                                    .direction = TransferRequest::Direction::download,
                                                    .slave = slave(3),
                                                    .address = 0x1000,
                                                    .data = data}));
    }
    if (edge % 3 == 0) {
      static_cast<void>(requests.try_push(
          ParameterRequest{.id = id, .slave = target, .number = *ParameterNumber::from(301)}));
    }
    if (edge % 7 == 0) static_cast<void>(requests.try_push(ControlWordRequest{id + 1, target, 7}));
    if (edge % 11 == 0) {
      static_cast<void>(requests.try_push(BroadcastRequest{id + 2, 1, {SlaveMask::all(), 200, 1, 2}}));
    }
    Terminal terminal;
    while (line.exchange().terminals.try_pop(terminal)) {
    }
  };
  auto seen = watch_slots(line, times, kSetUp, kSetUp + 10'000);
  for (const auto& [channel, what] : seen) EXPECT_EQ(what.late, 0u) << std::hex << channel;
  EXPECT_EQ(line.snapshot().state, State::start_up) << "the loop has stopped";
  EXPECT_GE(seen[identifier::actual_one].frames, 9'995u);
  EXPECT_GE(seen[identifier::actual_two].frames, 9'995u);
  for (std::size_t i = 0; i < kSlaves; ++i) {
    EXPECT_EQ(line.drive(i).fault(), 0) << i;
    EXPECT_EQ(line.drive(i).left_out(), 0u) << i;
  }
  EXPECT_TRUE(std::equal(data.begin(), data.end(), line.drive(3).memory().contents().begin() + 0xF00));
}

TEST_P(Slots, ActualValuesFollowTheReferences) {
  const MasterSettings settings = line_settings(GetParam());
  VirtualLine line(settings, drives_for(settings));
  line.on_edge = [&](std::uint64_t edge) { line.give_references(static_cast<std::uint32_t>(edge * 50)); };
  constexpr std::uint64_t kEdges = 3000;
  line.run(kEdges);
  for (unsigned i = 0; i < kSlaves; ++i) {
    ActualReport report;
    ASSERT_TRUE(line.exchange().actual[i].read(report)) << i;
    const double reference = 50.0 * static_cast<double>(report.values.interval[0]);
    EXPECT_NEAR(static_cast<double>(report.values.value[0]), reference, 50.0 * 100) << i;
    EXPECT_GT(report.values.value[0], 50u * 1000) << i;
  }
}

std::string rate_name(const testing::TestParamInfo<BitRate>& rate) {
  return std::to_string(slot_times(rate.param).bits_per_second / 1000) + "k";
}
INSTANTIATE_TEST_SUITE_P(AllRates, Slots,
                         testing::Values(BitRate::kbit125, BitRate::kbit250, BitRate::kbit500,
                                         BitRate::mbit1),
                         rate_name);

}  // namespace
}  // namespace cansyncd::test
