#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "daemon/j1939/gateway/message_requests.h"

namespace cansyncd {
namespace {

ClientIdentity client(std::uint8_t n) {
  ClientIdentity identity = {};
  identity[0] = n;
  return identity;
}

/// What a client may have open at the daemon.
constexpr JobId kOpen = 64;

/// The lanes of the desk, and what they gave.
struct Desk {
  explicit Desk(const MessageSendConfig& config = {})
      : lanes(MessageRequests(config, 65'536).lane_limits()) {}
  void add(JobId id, std::uint8_t whose, j1939::OrderKind kind) {
    lanes.add(id, client(whose), MessageRequests::lane_of({.id = id, .kind = kind}));
  }
  void hand_over() {
    EXPECT_TRUE(lanes.hand_over([this](JobId id) {
      given.push_back(id);
      return true;
    }));
  }
  bool has(JobId id) const { return std::find(given.begin(), given.end(), id) != given.end(); }

  FairLanes lanes;
  std::vector<JobId> given;
};

// Those of a client that nobody answers stay open for up to an hour.
TEST(MessageLanes, AClientWhoseRequestsStayOpenKeepsNobodyElseWaiting) {
  for (const auto kind : {j1939::OrderKind::send, j1939::OrderKind::request}) {
    Desk desk;
    for (JobId id = 1; id <= kOpen; ++id) desk.add(id, 1, kind);
    desk.hand_over();
    EXPECT_FALSE(desk.given.empty());
    desk.add(100, 2, j1939::OrderKind::send);
    desk.add(101, 2, j1939::OrderKind::request);
    desk.hand_over();
    EXPECT_TRUE(desk.has(100));
    EXPECT_TRUE(desk.has(101));
  }
}

TEST(MessageLanes, NoMoreAreAskedThanTheNodeWaitsFor) {
  Desk desk;
  for (JobId id = 1; id <= 4 * kOpen; ++id)
    desk.add(id, static_cast<std::uint8_t>(id % 4), j1939::OrderKind::request);
  desk.hand_over();
  EXPECT_EQ(desk.given.size(), j1939::kMostRequests);
}

TEST(MessageLanes, TheShortestQueueStillTakesOne) {
  Desk desk({.queue = 1});
  desk.add(1, 1, j1939::OrderKind::send);
  desk.add(2, 2, j1939::OrderKind::send);
  desk.hand_over();
  EXPECT_EQ(desk.given, std::vector<JobId>{1});
  desk.lanes.remove(1);
  desk.hand_over();
  EXPECT_TRUE(desk.has(2));
}

// J1939-73: who is asked for DM3 or DM11 erases its faults.
TEST(MessageRequests, AskingForWhatErasesFaultsIsAChange) {
  for (const auto& [group, erases] :
       {std::pair{0x0FECCu, true}, {0x0FED3u, true}, {0x0FECAu, false}, {0x0FEEBu, false}}) {
    j1939::Order order;
    order.kind = j1939::OrderKind::request;
    order.number = group;
    EXPECT_EQ(MessageRequests::effect_of(order).changes, erases) << group;
    j1939_MessageRequest sample = {};
    sample.kind = j1939_MESSAGE_ASK;
    sample.pgn = group;
    sample.destination = 3;
    J1939Exchange exchange(4, 4, 0);
    const J1939Config config;
    const auto change = MessageRequests::change_of(sample, {exchange, config, {}, {}});
    ASSERT_EQ(change.has_value(), erases) << group;
    if (!change) continue;
    EXPECT_EQ(change->new_value,
              fmt::format("request of PGN 0x{:05X} to address 3, which erases its faults", group));
  }
}

}  // namespace
}  // namespace cansyncd
