#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>

#include "cansync.h"
#include "cansync/dds/topics.h"
#include "daemon/desk/dropped_replies.h"
#include "daemon/desk/gateway_replies.h"
#include "support/dds_places.h"

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

using Outbox = ReplyOutbox<cansync_CommandReply>;

cansync_CommandReply key_of(std::uint32_t client) {
  cansync_CommandReply reply = {};
  for (unsigned i = 0; i < 4; ++i) reply.client[i] = static_cast<std::uint8_t>(client >> (8 * i));
  return reply;
}

/// A reply whose reader is not there yet keeps all behind it waiting.
struct Held {
  Held() {
    Place nowhere = {};
    nowhere[0] = 1;
    outbox.send(key_of(0), nowhere, kStart);
  }
  TwoPlaces places;
  gateway::dds::Participant participant{places.here};
  gateway::dds::DataSignal signal;
  Outbox outbox{participant, signal};
};

TEST(ReplyOutbox, ClientsThatAreGoneFillItNoMoreThanReplies) {
  Held held;
  ASSERT_EQ(held.outbox.waiting(), 1u);
  for (std::uint32_t i = 1; i <= Outbox::kWaiting + 1000; ++i) {
    held.outbox.forget(key_of(i), kStart);
    ASSERT_LE(held.outbox.waiting(), Outbox::kWaiting) << "after " << i;
  }
  EXPECT_EQ(held.outbox.waiting(), Outbox::kWaiting);
  EXPECT_EQ(held.outbox.take_dropped(), 1u) << "the reply was the oldest; keys are no replies";
}

TEST(ReplyOutbox, RepliesOfManyPlacesFillItNoMoreThanThat) {
  Held held;
  Place place = {};
  place[0] = 2;
  for (std::uint32_t i = 1; i <= Outbox::kWaiting + 1000; ++i) {
    place[1] = static_cast<std::uint8_t>(i % 100);
    held.outbox.send(key_of(i), place, kStart);
    ASSERT_LE(held.outbox.waiting(), Outbox::kWaiting) << "after " << i;
  }
  EXPECT_EQ(held.outbox.waiting(), Outbox::kWaiting);
  EXPECT_EQ(held.outbox.take_dropped(), 1001u);
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
