#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>

#include "cansync.h"
#include "cansync/dds/topics.h"
#include "daemon/desk/dropped_replies.h"
#include "daemon/desk/gateway_replies.h"
#include "support/dds_places.h"
#include "support/long_wait.h"

namespace cansyncd {
namespace {

constexpr SteadyTime kStart{std::chrono::seconds(100)};

TEST(DroppedReplies, NoneIsLostBetweenTwoEvents) {
  DroppedReplies dropped;
  EXPECT_EQ(dropped.take(kStart), 0u);
  EXPECT_FALSE(dropped.next());
  dropped.add(3);
  EXPECT_EQ(dropped.take(kStart), 3u) << "the first are told at once";
  std::uint64_t told = 0;
  for (unsigned i = 1; i <= 900; ++i) {
    dropped.add(1);
    told += dropped.take(kStart + std::chrono::milliseconds(i));
  }
  EXPECT_EQ(told, 0u) << "not an event for each";
  ASSERT_TRUE(dropped.next());
  EXPECT_EQ(*dropped.next(), kStart + DroppedReplies::kPeriod);
  EXPECT_EQ(dropped.take(*dropped.next()), 900u);
  EXPECT_EQ(dropped.take(kStart + 2 * DroppedReplies::kPeriod), 0u) << "nothing is told twice";
}

template <class Reply>
Reply reply_to(std::uint32_t client) {
  Reply reply = {};
  for (unsigned i = 0; i < 4; ++i) reply.client[i] = static_cast<std::uint8_t>(client >> (8 * i));
  return reply;
}

Place place_number(std::uint8_t number) {
  Place place = {};
  place[0] = 2;
  place[1] = number;
  return place;
}

/// Where the replies to one client come.
gateway::dds::Partitions own_partition(const gateway::dds::ParticipantOptions& options, std::uint8_t client) {
  return {gateway::dds::reply_partition(options.partition, {client})};
}

/// An outbox, and a participant for readers of its replies.
template <class Reply>
struct Outbox {
  explicit Outbox(const ReplyLimits& limits = {}) : box(participant, signal, limits) {}
  void send(std::uint32_t client, std::vector<std::uint8_t> data = {}) {
    Reply reply = reply_to<Reply>(client);
    if constexpr (requires { reply.data; }) {
      reply.data._buffer = data.data();
      reply.data._length = reply.data._maximum = static_cast<std::uint32_t>(data.size());
    }
    box.send(reply, place_number(static_cast<std::uint8_t>(client)), std::chrono::steady_clock::now(),
             std::move(data));
  }
  /// Goes on until the condition holds.
  template <class Condition>
  bool until(gateway::dds::DataSignal& changed, Condition&& condition,
             std::chrono::seconds ahead = std::chrono::seconds(0)) {
    // Acknowledgements raise nothing: the gateway looks every 10 ms while something waits.
    const auto end = std::chrono::steady_clock::now() + gateway::kLongWait;
    while (std::chrono::steady_clock::now() < end) {
      box.retry(std::chrono::steady_clock::now() + ahead);
      if (condition()) return true;
      (void)changed.wait(10);
      changed.clear();
    }
    return false;
  }

  TwoPlaces places;
  gateway::dds::Participant participant{places.here};
  gateway::dds::Participant there{places.there};
  gateway::dds::DataSignal signal;
  ReplyOutbox<Reply> box;
};

TEST(ReplyOutbox, OfClientsItNeverWroteToThereIsNothingToForget) {
  Outbox<cansync_CommandReply> outbox;
  for (std::uint32_t i = 1; i <= 1000; ++i) outbox.box.forget(reply_to<cansync_CommandReply>(i), kStart);
  EXPECT_EQ(outbox.box.clients(), 0u);
  EXPECT_FALSE(outbox.box.next(kStart));
}

TEST(ReplyOutbox, RepliesOfManyFillItNoMoreThanThatAndWhoHasMostLosesThem) {
  Outbox<cansync_CommandReply> outbox({.clients = 8, .waiting = 100});
  outbox.send(1);
  for (std::uint32_t i = 0; i < 1000; ++i) {
    outbox.send(2 + i % 2);
    ASSERT_LE(outbox.box.waiting(), 100u) << "after " << i;
  }
  for (std::uint32_t i = 1; i <= 20; ++i) outbox.send(i);
  EXPECT_EQ(outbox.box.clients(), 8u) << "nobody of whom something waits gives its place to others";
  EXPECT_EQ(outbox.box.waiting(), 100u);
  EXPECT_EQ(outbox.box.take_dropped(), 1021u - 100u);
}

TEST(ReplyOutbox, OneParticipantTakesNoMoreThanItsShare) {
  Outbox<cansync_CommandReply> outbox({.waiting_per_place = 10});
  for (unsigned i = 0; i < 50; ++i) outbox.send(1);
  outbox.send(2);
  EXPECT_EQ(outbox.box.waiting(), 11u);
  EXPECT_EQ(outbox.box.take_dropped(), 40u);
}

TEST(ReplyOutbox, ARefusedClientMoreTakesThePlaceOfTheOneThatWasIdleLongest) {
  Outbox<cansync_CommandReply> outbox({.clients = 4});
  gateway::dds::DataSignal signal;
  gateway::dds::Reader<cansync_CommandReply> reader(outbox.there, replies_to_all(outbox.places.there),
                                                    &signal);
  std::size_t got = 0;
  for (std::uint32_t client = 1; client <= 12; ++client) {
    outbox.send(client);
    ASSERT_TRUE(outbox.until(signal, [&] {
      (void)reader.take([&](const cansync_CommandReply&) { ++got; });
      return got == client;
    })) << client;
    outbox.box.wait_for_readers(DDS_SECS(20));
    EXPECT_LE(outbox.box.clients(), 4u);
  }
  EXPECT_EQ(outbox.box.take_dropped(), 0u);
}

TEST(ReplyOutbox, RepliesReachTheirClientAloneAndAClientThatIsGoneLosesItsWriter) {
  Outbox<cansync_TransferReply> outbox;
  gateway::dds::DataSignal signal;
  using Reader = gateway::dds::Reader<cansync_TransferReply>;
  Reader asks(outbox.there, own_partition(outbox.places.there, 1), &signal);
  Reader other(outbox.there, own_partition(outbox.places.there, 2), &signal);
  ASSERT_TRUE(outbox.until(signal, [&] { return asks.matched() == 1 && other.matched() == 1; }))
      << "both know that somebody answers before anything was asked";
  outbox.send(1, std::vector<std::uint8_t>(1 << 20, 7));
  std::size_t bytes = 0;
  ASSERT_TRUE(outbox.until(signal, [&] {
    (void)asks.take([&](const cansync_TransferReply& reply) { bytes += reply.data._length; });
    return bytes == 1 << 20;
  }));
  outbox.send(2);
  ASSERT_TRUE(outbox.until(signal, [&] {
    return other.take([](const cansync_TransferReply& reply) {
      EXPECT_EQ(reply.data._length, 0u) << "what came is its own";
    }) == 1;
  }));
  EXPECT_EQ(asks.matched(), 2u);
  outbox.box.forget(reply_to<cansync_TransferReply>(1), std::chrono::steady_clock::now());
  EXPECT_TRUE(outbox.until(signal, [&] { return asks.matched() == 1; }));
  EXPECT_EQ(outbox.box.clients(), 1u);
  EXPECT_EQ(other.matched(), 2u);
}

TEST(ReplyOutbox, AReaderOfTheRepliesOfAllHearsNothingAndHoldsNobodyUp) {
  Outbox<cansync_CommandReply> outbox;
  gateway::dds::DataSignal signal;
  using Reader = gateway::dds::Reader<cansync_CommandReply>;
  const std::string bus = outbox.places.there.partition;
  const Reader spy(outbox.there, gateway::dds::Partitions{gateway::dds::every_reply_partition(bus)}, &signal);
  const Reader everything(outbox.there, gateway::dds::Partitions{"*"}, &signal);
  Reader asks(outbox.there, own_partition(outbox.places.there, 1), &signal);
  outbox.send(1);
  ASSERT_TRUE(outbox.until(signal, [&] { return asks.take([](const cansync_CommandReply&) {}) == 1; }));
  EXPECT_EQ(spy.matched(), 0u);
  EXPECT_EQ(everything.matched(), 0u);
  outbox.send(2);
  ASSERT_TRUE(outbox.until(
      signal, [&] { return outbox.box.empty(); }, 3 * ReplyOutbox<cansync_CommandReply>::kMatchTime));
  EXPECT_EQ(outbox.box.take_dropped(), 1u) << "its own reader is not there";
}

/// A client that takes nothing while all room is used up; `acknowledged` replies came to it one by one.
void stand_still(unsigned acknowledged) {
  constexpr std::size_t kBytes = 20000;
  constexpr unsigned kKept = 16;
  constexpr unsigned kMany = 40;
  Outbox<cansync_TransferReply> outbox({.under_way_each = 100000, .under_way = 90000});
  gateway::dds::DataSignal signal;
  using Reader = gateway::dds::Reader<cansync_TransferReply>;
  Reader still(outbox.there, own_partition(outbox.places.there, 1), &signal);
  // In one process DDS would wait for the first before it gives anything to the second.
  Reader takes(outbox.participant, own_partition(outbox.places.here, 2), &signal);
  for (unsigned i = 0; i < acknowledged; ++i) {
    outbox.send(1, std::vector<std::uint8_t>(kBytes));
    ASSERT_TRUE(outbox.until(signal, [&] { return outbox.box.empty(); }));
    outbox.box.wait_for_readers(DDS_SECS(20));
  }
  for (unsigned i = acknowledged; i < kMany; ++i) outbox.send(1, std::vector<std::uint8_t>(kBytes));
  // Its reader has as many as it keeps, at least one more is under way, and no more than may be.
  ASSERT_TRUE(outbox.until(
      signal, [&] { return outbox.box.waiting() < kMany - kKept && outbox.box.under_way() > 4 * kBytes; }))
      << outbox.box.waiting() << " wait";
  EXPECT_LE(outbox.box.under_way(), 90000u);
  std::size_t sent = 0;
  std::size_t bytes = 0;
  std::uint64_t dropped = 0;
  const auto send_and_take = [&] {
    (void)takes.take([&](const cansync_TransferReply& reply) { bytes += reply.data._length; });
    dropped += outbox.box.take_dropped();
    EXPECT_LE(outbox.box.under_way(), 90000u);
    if (bytes < sent * kBytes) return false;
    if (sent >= 8 && dropped != 0) return true;
    // More than eight when the first had still taken some meanwhile, and lost nothing.
    outbox.send(2, std::vector<std::uint8_t>(kBytes));
    ++sent;
    return false;
  };
  EXPECT_TRUE(outbox.until(signal, send_and_take, std::chrono::seconds(6)))
      << bytes << " of " << sent * kBytes << " bytes came, " << dropped << " replies were dropped";
  EXPECT_TRUE(outbox.until(signal, [&] {
    (void)still.take([](const cansync_TransferReply&) {});
    return outbox.box.empty();
  })) << "it goes on, and gets what was not lost";
}

TEST(ReplyOutbox, WhoStandsStillLosesItsOwnRepliesAndOthersGetTheirs) {
  // Four go at a time: the reader is full after the last of four, or between two of them.
  stand_still(0);
  stand_still(1);
}

TEST(SettleCause, ARefusalNeverGoesWithoutACauseAndNothingElseWithOne) {
  for (unsigned code = gateway_REPLY_DONE; code <= gateway_REPLY_REPLACED; ++code) {
    for (unsigned cause = gateway_CAUSE_NONE; cause < gateway::dds::kCauses; ++cause) {
      cansync_CommandReply reply = {};
      reply.code = static_cast<gateway_ReplyCode>(code);
      reply.cause = static_cast<gateway_RefusalCause>(cause);
      const bool right = (code == gateway_REPLY_REFUSED) == (cause != gateway_CAUSE_NONE);
      EXPECT_EQ(gateway::dds::settle_cause(reply), right) << code << " with " << cause;
      EXPECT_TRUE(gateway::dds::fits(reply.code, reply.cause));
      EXPECT_TRUE(!right || reply.cause == cause) << "what is right stays";
    }
  }
}

}  // namespace
}  // namespace cansyncd
