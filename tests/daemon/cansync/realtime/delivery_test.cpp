// What becomes of telegrams that nobody acknowledges: the realtime loop on the SocketCAN bus, with a kernel
// that keeps them as a controller does, and delivers all of them when the cable is back.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <vector>

#include "cansync/telegram/telegram.h"
#include "socketcan_rig.h"

namespace cansyncd::test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

constexpr std::uint64_t kOff = 500;   ///< the cable is off at this edge
constexpr std::uint64_t kOn = 4'000;  ///< and back at this one
constexpr can::Time kInterval = milliseconds(1);

/// A line in active operation with reference values in every interval, a control word that enables and a
/// broadcast every tenth; the link watch does what it is asked for two intervals later.
struct Cut : Rig {
  using Rig::Rig;

  std::uint64_t off = kOff;
  std::uint64_t on = kOn;
  std::uint64_t asked = 0;  ///< interrupts of the watch that were served
  std::uint64_t serve_at = 0;
  can::Time longest_wait{0};
  std::function<void(std::uint64_t)> also = [](std::uint64_t) {};

  void play(std::uint64_t edges) {
    on_edge = [this](std::uint64_t edge) {
      if (edge > 200) give_references();
      if (edge > 200 && edge % 10 == 0) ask(edge);
      if (edge == off) kernel.cable(false);
      if (edge == on) kernel.cable(true);
      also(edge);
      if (links.interrupts != asked && serve_at == 0) serve_at = edge + 2;
      if (serve_at == edge) {
        asked = links.interrupts;
        serve_at = 0;
        watch.look();
      }
    };
    run(edges);
    for (const auto& late : kernel.late) longest_wait = std::max(longest_wait, late.waited);
  }

  void ask(std::uint64_t edge) {
    EXPECT_TRUE(exchange.requests.try_push(cansync::ControlWordRequest{
        .id = edge * 2, .slave = *cansync::SlaveNumber::from(edge / 10 % 4), .control_word = 0x000F}));
    EXPECT_TRUE(exchange.requests.try_push(
        cansync::BroadcastRequest{.id = edge * 2 + 1, .action = {.slaves = {0xF}, .command = 200}}));
    Terminal terminal;
    while (exchange.terminals.try_pop(terminal)) {
    }
  }
};

/// What stood in the controller for longer goes out at a time at which nobody expects it: two intervals until
/// nobody acknowledges, two until the watch has reset the controller, and what is left of the first.
constexpr can::Time kLongest = 5 * kInterval;

TEST(Delivery, WhatNobodyAcknowledgesDoesNotGoOutWhenTheCableIsBack) {
  Cut rig;
  rig.play(8000);
  EXPECT_LE(rig.longest_wait, kLongest);
  EXPECT_LE(rig.kernel.attempts, 5u + 5u) << "two intervals, then one telegram a second";
  EXPECT_LE(rig.links.asked.size(), 2 * 5u) << "and a reset for each";
  EXPECT_EQ(rig.snapshot().synchronized.bits, 0xFu) << "the line goes on by itself";
  const auto changes = rig.reported<DeliveryChanged>();
  ASSERT_EQ(changes.size(), 2u) << "told on the edge";
  EXPECT_EQ(changes[0].to, can::Delivery::unacknowledged);
  EXPECT_LE(changes[0].when.interval, kOff + 5);
  EXPECT_EQ(changes[1].to, can::Delivery::normal);
  EXPECT_LE(changes[1].when.interval, kOn + 1010);
  EXPECT_EQ(changes[1].never_sent, rig.kernel.attempts);
  EXPECT_GT(changes[1].left_out, 7000u);
  EXPECT_TRUE(rig.reported<SendingChanged>().empty()) << "it has a report of its own";
}

TEST(Delivery, NorWhenItIsBackAtAnyOtherTime) {
  for (std::uint64_t later = 0; later < 20; ++later) {
    Cut rig;
    rig.on = kOff + later;
    rig.play(2500);
    EXPECT_LE(rig.longest_wait, kLongest) << later;
    EXPECT_EQ(rig.snapshot().synchronized.bits, 0xFu) << later;
    if (later <= 1) {
      EXPECT_TRUE(rig.reported<DeliveryChanged>().empty()) << "in the same interval nothing is held back";
      EXPECT_TRUE(rig.links.asked.empty());
    }
  }
}

TEST(Delivery, InOneShotModeEachTelegramIsTriedInItsIntervalAndNothingIsReset) {
  auto facts = can::test::can0();
  facts.one_shot = true;
  Cut rig(facts);
  rig.kernel.one_shot = true;
  rig.play(8000);
  EXPECT_TRUE(rig.kernel.late.empty());
  EXPECT_TRUE(rig.links.asked.empty());
  EXPECT_GT(rig.kernel.attempts, 3000u) << "the line is back as soon as the cable is";
  const auto changes = rig.reported<DeliveryChanged>();
  ASSERT_EQ(changes.size(), 2u);
  EXPECT_EQ(changes[0].to, can::Delivery::unacknowledged);
  EXPECT_LE(changes[1].when.interval, kOn + 2);
  EXPECT_EQ(changes[1].left_out, 0u);
  EXPECT_EQ(rig.snapshot().synchronized.bits, 0xFu);
}

TEST(Delivery, AControllerThatIsNotAsOneShotAsItSaysIsResetWhenItsQueueIsFull) {
  auto facts = can::test::can0();
  facts.one_shot = true;
  Cut rig(facts);
  rig.play(8000);
  EXPECT_LE(rig.longest_wait, 8 * kInterval);
  EXPECT_FALSE(rig.links.asked.empty());
  EXPECT_EQ(rig.snapshot().synchronized.bits, 0xFu);
}

TEST(Delivery, AFullQueueMeanwhileChangesNothing) {
  Cut rig;
  rig.also = [&](std::uint64_t edge) { rig.kernel.send_error = edge == kOff + 1 ? -ENOBUFS : 0; };
  rig.play(8000);
  EXPECT_LE(rig.longest_wait, kLongest);
  EXPECT_EQ(rig.reported<DeliveryChanged>().size(), 2u);
  EXPECT_EQ(rig.snapshot().synchronized.bits, 0xFu);
}

TEST(Delivery, WithoutTheRightToResetNothingMoreIsHandedOver) {
  Cut rig;
  rig.links.set_up_result = -EPERM;
  rig.play(8000);
  EXPECT_LE(rig.kernel.late.size(), 5u) << "of the interval in which the cable went, and the next";
  for (const auto& late : rig.kernel.late) EXPECT_GE(late.waited, (kOn - kOff - 2) * kInterval);
  const auto changes = rig.reported<DeliveryChanged>();
  ASSERT_EQ(changes.size(), 3u);
  EXPECT_EQ(changes[1].to, can::Delivery::not_emptied);
  EXPECT_EQ(changes[2].to, can::Delivery::normal);
  EXPECT_LE(changes[2].when.interval, kOn + 3) << "all echoes came: the controller is empty";
  EXPECT_EQ(changes[2].never_sent, 0u);
  EXPECT_EQ(rig.snapshot().synchronized.bits, 0xFu);
}

TEST(Delivery, AnInterfaceThatWasDownIsEmpty) {
  Cut rig;
  rig.links.set_up_result = -EPERM;
  // Down and up too fast for the watch.
  rig.also = [&](std::uint64_t edge) {
    if (edge != kOn - 1) return;
    rig.kernel.set_up(false);
    rig.kernel.set_up(true);
  };
  rig.play(8000);
  EXPECT_LE(rig.kernel.late.size(), 1u) << "the one that is tried";
  EXPECT_LE(rig.longest_wait, kLongest);
  EXPECT_EQ(rig.snapshot().synchronized.bits, 0xFu);
}

TEST(Delivery, AnInterfaceThatIsDownForAWhileMeanwhile) {
  Cut rig;
  rig.also = [&](std::uint64_t edge) {
    auto facts = can::test::can0();
    if (edge == kOff + 100) {
      facts.up = false;
      rig.kernel.set_up(false);
      rig.link(facts);
    }
    if (edge == kOff + 300) {
      rig.kernel.set_up(true);
      rig.link(facts);
    }
  };
  rig.play(8000);
  EXPECT_LE(rig.longest_wait, kLongest);
  EXPECT_EQ(rig.reported<LinkChanged>().size(), 2u);
  EXPECT_EQ(rig.reported<DeliveryChanged>().size(), 2u);
  EXPECT_EQ(rig.snapshot().synchronized.bits, 0xFu);
}

TEST(Delivery, LateEchoesStopNoLine) {
  Cut rig;
  rig.off = rig.on = 0;
  rig.also = [&](std::uint64_t edge) { rig.kernel.deaf = edge % 100 == 50; };
  rig.play(3000);
  EXPECT_TRUE(rig.reported<DeliveryChanged>().empty());
  EXPECT_TRUE(rig.links.asked.empty());
  EXPECT_EQ(rig.snapshot().synchronized.bits, 0xFu);
  EXPECT_EQ(rig.latest.controller.unacknowledged, 0u);
  EXPECT_LE(rig.latest.counters.left_out, 30u) << "one at most for each of them";
}

TEST(Delivery, ABusThatWasNeverThereIsTriedOnceASecond) {
  Cut rig;
  rig.off = 0;
  rig.play(9000);
  EXPECT_LE(rig.longest_wait, kLongest);
  EXPECT_LE(rig.kernel.attempts, 6u) << "one telegram at a time until the first echo";
  EXPECT_EQ(rig.snapshot().synchronized.bits, 0xFu);
}

}  // namespace
}  // namespace cansyncd::test
