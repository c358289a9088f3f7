// Messages of a recording: what any two nodes sent each other is assembled as the daemon would, in virtual time.
#include "j1939/client/recorded_bus.h"

#include <gtest/gtest.h>

#include <optional>
#include <vector>

#include "node_rig.h"

namespace {

using namespace j1939;
using client::RecordedBus;
using std::chrono::milliseconds;
using test::frame;

/// Gives frames, 10 ms apart, to a recorded bus.
class RecordedBusTest : public testing::Test {
 protected:
  struct Whole {
    Message message;
    std::vector<std::uint8_t> data;
  };
  std::optional<Whole> receive(const can::Frame& given, std::uint32_t number = 0) {
    time_ += step_;
    const auto message = bus_.receive(number, given, time_);
    if (!message) return std::nullopt;
    return Whole{*message, {message->data.begin(), message->data.end()}};
  }
  /// PGN 0FEEC in 10 bytes from 0x21 to 0x33, by a connection.
  void request() { EXPECT_FALSE(receive(frame(0x18EC3321, {16, 10, 0, 2, 255, 0xEC, 0xFE, 0}))); }
  void clear(int first, int packets = 2) {
    EXPECT_FALSE(receive(frame(0x18EC2133, {17, packets, first, 255, 255, 0xEC, 0xFE, 0})));
  }
  std::optional<Whole> packet(int number) {
    return receive(frame(0x18EB3321, {number, number, 2, 3, 4, 5, 6, 7}));
  }

  RecordedBus bus_;
  milliseconds step_{10};
  Time time_ = std::chrono::seconds(1'700'000'000);
};

TEST_F(RecordedBusTest, AFrameIsAMessageWhoeverItIsFor) {
  const auto got = receive(frame(0x0CEF3321, {1, 2, 3}));
  ASSERT_TRUE(got);
  EXPECT_EQ(got->message.number, 0xEF00u);
  EXPECT_EQ(got->message.priority, 3);
  EXPECT_EQ(got->message.destination, 0x33);
  EXPECT_EQ(got->message.end, time_);
  EXPECT_EQ(got->data, (std::vector<std::uint8_t>{1, 2, 3}));
}

TEST_F(RecordedBusTest, ABroadcastInPacketsIsOneMessage) {
  EXPECT_FALSE(receive(frame(0x18ECFF21, {32, 10, 0, 2, 255, 0xCA, 0xFE, 0})));
  EXPECT_FALSE(receive(frame(0x18EBFF21, {1, 1, 2, 3, 4, 5, 6, 7})));
  const auto got = receive(frame(0x18EBFF21, {2, 8, 9, 10, 255, 255, 255, 255}));
  ASSERT_TRUE(got);
  EXPECT_EQ(got->message.number, 0xFECAu);
  EXPECT_EQ(got->message.transport, Transport::broadcast);
  EXPECT_EQ(got->data, test::counting(10));
  EXPECT_EQ(got->message.end, time_) << "its own time, not that of the announcement";
  EXPECT_EQ(bus_.counters().incomplete, 0u);
}

TEST_F(RecordedBusTest, AConnectionBetweenOthersIsAssembled) {
  request();
  clear(1, 1);
  EXPECT_FALSE(packet(1));
  clear(2, 1);
  const auto got = packet(2);
  ASSERT_TRUE(got);
  EXPECT_EQ(got->message.source, 0x21);
  EXPECT_EQ(got->message.destination, 0x33);
  EXPECT_EQ(got->message.transport, Transport::connection);
  EXPECT_EQ(got->data, (std::vector<std::uint8_t>{1, 2, 3, 4, 5, 6, 7, 2, 2, 3}));
}

TEST_F(RecordedBusTest, WhatTheReceiverAsksForAgainCountsOnce) {
  request();
  clear(1);
  EXPECT_FALSE(packet(1));
  clear(1);
  EXPECT_FALSE(packet(1));
  EXPECT_TRUE(packet(2));
}

TEST_F(RecordedBusTest, AHeldConnectionStaysOpen) {
  request();
  clear(1, 1);
  EXPECT_FALSE(packet(1));
  step_ = milliseconds(500);
  for (int i = 0; i < 8; ++i) clear(0xFF, 0);
  clear(2, 1);
  EXPECT_TRUE(packet(2));
}

TEST_F(RecordedBusTest, WhatIsMissingIsCountedAndNoMessage) {
  request();
  clear(1);
  EXPECT_FALSE(packet(2));
  EXPECT_EQ(bus_.counters().incomplete, 1u) << "open at the end of the recording";
  EXPECT_FALSE(receive(frame(0x18EC3321, {255, 3, 255, 255, 255, 0xEC, 0xFE, 0})));
  EXPECT_EQ(bus_.counters().incomplete, 1u);
  EXPECT_FALSE(packet(1));
  EXPECT_FALSE(packet(2));
}

TEST_F(RecordedBusTest, BothEndsMayAbort) {
  request();
  EXPECT_FALSE(receive(frame(0x18EC2133, {255, 1, 255, 255, 255, 0xEC, 0xFE, 0})));
  EXPECT_FALSE(packet(1));
  EXPECT_FALSE(packet(2));
  EXPECT_EQ(bus_.counters().incomplete, 1u);
}

TEST_F(RecordedBusTest, BusesAndDestinationsDoNotMix) {
  request();
  EXPECT_FALSE(receive(frame(0x18EC4421, {16, 10, 0, 2, 255, 0xEB, 0xFE, 0})))
      << "the same source to another";
  EXPECT_FALSE(receive(frame(0x18EC3321, {16, 9, 0, 2, 255, 0xEA, 0xFE, 0}), 1))
      << "the same nodes elsewhere";
  EXPECT_FALSE(packet(1));
  EXPECT_FALSE(receive(frame(0x18EB4421, {1, 1, 1, 1, 1, 1, 1, 1})));
  EXPECT_FALSE(receive(frame(0x18EB3321, {1, 9, 9, 9, 9, 9, 9, 9}), 1));
  EXPECT_EQ(packet(2)->message.number, 0xFEECu);
  EXPECT_EQ(receive(frame(0x18EB4421, {2, 1, 1, 1, 1, 1, 1, 1}))->message.number, 0xFEEBu);
  EXPECT_EQ(receive(frame(0x18EB3321, {2, 9, 9, 9, 9, 9, 9, 9}), 1)->data, std::vector<std::uint8_t>(9, 9));
}

TEST_F(RecordedBusTest, AClockThatGoesBackEndsNothing) {
  request();
  time_ -= std::chrono::hours(1);
  clear(1);
  EXPECT_FALSE(packet(1));
  const auto got = packet(2);
  ASSERT_TRUE(got);
  EXPECT_EQ(got->message.end, time_);
}

TEST_F(RecordedBusTest, WhatIsWaitedForTooLongEnds) {
  request();
  clear(1);
  time_ += std::chrono::seconds(2);
  EXPECT_FALSE(packet(1));
  EXPECT_FALSE(packet(2));
  EXPECT_EQ(bus_.counters().incomplete, 1u);
}

TEST_F(RecordedBusTest, LongMessagesComeByTheExtendedProtocol) {
  constexpr int kSize = 1792;  // 256 packets
  EXPECT_FALSE(receive(frame(0x18C83321, {20, kSize & 0xFF, kSize >> 8, 0, 0, 0xEC, 0xFE, 0})));
  std::optional<Whole> got;
  for (int next = 1; next <= 256; next += 128) {
    EXPECT_FALSE(receive(frame(0x18C82133, {21, 128, next & 0xFF, next >> 8, 0, 0xEC, 0xFE, 0})));
    EXPECT_FALSE(receive(frame(0x18C83321, {22, 128, (next - 1) & 0xFF, (next - 1) >> 8, 0, 0xEC, 0xFE, 0})));
    for (int i = 1; i <= 128; ++i) got = receive(frame(0x18C73321, {i, 1, 2, 3, 4, 5, 6, 7}));
  }
  ASSERT_TRUE(got);
  EXPECT_EQ(got->message.transport, Transport::extended);
  EXPECT_EQ(got->data.size(), static_cast<std::size_t>(kSize));
}

TEST_F(RecordedBusTest, MemoryIsBoundedWhateverComes) {
  for (std::uint32_t number = 0; number < 8; ++number)
    for (std::uint32_t address = 0; address < 254; ++address) {
      const std::uint32_t to = address << 8;
      (void)receive(frame(0x18EC00FA | to, {16, 10, 0, 2, 255, 0xEC, 0xFE, 0}), number);
      (void)receive(frame(0x18C800FA | to, {20, 0, 0, 1, 0, 0xEC, 0xFE, 0}), number);
    }
  EXPECT_EQ(bus_.counters().incomplete, RecordedBus::kMostReceivers);
  EXPECT_EQ(bus_.counters().refused, 2u * 8 * 254 - RecordedBus::kMostReceivers);
}

TEST_F(RecordedBusTest, OtherFramesAreCounted) {
  can::Frame standard = frame(0x123, {1});
  standard.extended = false;
  EXPECT_FALSE(receive(standard));
  can::Frame remote = frame(0x18FEEE21, {});
  remote.remote = true;
  EXPECT_FALSE(receive(remote));
  EXPECT_EQ(bus_.counters().foreign, 2u);
}

}  // namespace
