#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "daemon/cansync/requests/lanes.h"
#include "daemon/desk/job_book.h"
#include "daemon/desk/rejections.h"
#include "daemon/desk/request_numbers.h"

namespace cansyncd {
namespace {

constexpr Lane kSlaveOne{LaneKind::parameter, 1};

ClientIdentity client(std::uint8_t n) {
  ClientIdentity identity = {};
  identity[0] = n;
  return identity;
}

/// The master as far as lanes know it: what was given, in order.
struct Line {
  explicit Line(const cansync::CommandChannelSettings& settings = {}) : lanes(lane_limits(settings)) {}
  void hand_over() {
    EXPECT_TRUE(lanes.hand_over([this](JobId id) {
      given.push_back(id);
      return true;
    }));
  }
  /// The oldest of what was given ends.
  JobId end_first() {
    const JobId id = given.at(ended++);
    lanes.remove(id);
    hand_over();
    return id;
  }
  FairLanes lanes;
  std::vector<JobId> given;
  std::size_t ended = 0;
};

TEST(FairLanes, OneClientsRequestsKeepTheirOrder) {
  Line line;
  for (JobId id = 1; id <= 10; ++id) line.lanes.add(id, client(1), kSlaveOne);
  line.hand_over();
  EXPECT_EQ(line.given, (std::vector<JobId>{1, 2, 3, 4}));
  for (JobId id = 1; id <= 10; ++id) EXPECT_EQ(line.end_first(), id);
}

TEST(FairLanes, WhoWaitsIsToldBehindWhomAndForLaneAlone) {
  Line line;
  const Lane transfer{LaneKind::transfer, 1};
  line.lanes.add(1, client(1), transfer);
  line.lanes.add(2, client(2), transfer);
  line.lanes.add(3, client(2), {LaneKind::transfer, 2});
  line.hand_over();
  const std::vector<JobId> ids = {1, 2, 3, 99};
  const auto turns = line.lanes.turns(ids);
  ASSERT_EQ(turns.size(), ids.size());
  EXPECT_EQ(std::pair(turns[0].waits, turns[0].behind), std::pair(false, JobId{0}));
  EXPECT_EQ(std::pair(turns[1].waits, turns[1].behind), std::pair(true, JobId{1}));
  EXPECT_FALSE(turns[2].waits) << "another slave's lane is free";
  EXPECT_FALSE(turns[3].waits) << "unknown";
  (void)line.end_first();
  EXPECT_FALSE(line.lanes.turns(ids)[1].waits);
}

/// One client keeps 64 of its 10,000 requests waiting all the time; the other's one is never further back
/// than what the slave has already, and one more.
TEST(FairLanes, TenThousandRequestsDoNotKeepAnotherClientWaiting) {
  Line line;
  JobId next = 1;
  for (; next <= 64; ++next) line.lanes.add(next, client(1), kSlaveOne);
  line.hand_over();
  std::vector<JobId> of_second;
  unsigned since = 0;
  unsigned longest = 0;
  while (next <= 10'000) {
    if (of_second.empty() && next % 7 == 0) {
      of_second.push_back(1'000'000 + next);
      line.lanes.add(of_second.back(), client(2), kSlaveOne);
      line.hand_over();
      since = 0;
    }
    const JobId ended = line.end_first();
    ++since;
    if (ended < 1'000'000) {
      line.lanes.add(next++, client(1), kSlaveOne);
    } else {
      longest = std::max(longest, since);
      of_second.clear();
    }
  }
  // Four the slave had, one of the other client, and its own.
  EXPECT_GT(longest, 0u);
  EXPECT_LE(longest, 6u);
}

TEST(FairLanes, EveryClientWithRequestsWaitingHasOneTurnInARound) {
  Line line;
  JobId next = 1;
  for (std::uint8_t n = 1; n <= 5; ++n) {
    for (int i = 0; i < 20; ++i) line.lanes.add(next++, client(n), kSlaveOne);
  }
  line.lanes.add(1000, client(6), kSlaveOne);
  line.hand_over();
  while (line.ended < line.given.size() && line.end_first() != 1000) {
  }
  // Nothing was given to anybody before, so it is the sixth; the bound says 4 + 5 + 1.
  EXPECT_EQ(line.ended, 6u);
}

/// A client that asks again as soon as it is answered does not come in between again.
TEST(FairLanes, AskingAgainAtOnceGainsNothing) {
  Line line;
  JobId quick = 1000;
  line.lanes.add(quick, client(1), {LaneKind::transfer, 1});
  line.lanes.add(quick + 1, client(2), {LaneKind::transfer, 1});
  for (JobId id = 1; id <= 3; ++id) line.lanes.add(id, client(3), {LaneKind::transfer, 1});
  line.hand_over();
  quick += 2;
  std::vector<std::size_t> done_at;
  while (done_at.size() < 3) {
    const JobId ended = line.given.at(line.ended);
    if (ended >= 1000) line.lanes.add(quick++, client(ended % 2 == 0 ? 1 : 2), {LaneKind::transfer, 1});
    line.end_first();
    if (ended < 1000) done_at.push_back(line.ended);
  }
  EXPECT_LE(done_at[0], 4u);
  EXPECT_LE(done_at[1] - done_at[0], 3u);
  EXPECT_LE(done_at[2] - done_at[1], 3u);
}

TEST(FairLanes, SlavesAndKindsDoNotWaitForEachOther) {
  Line line;
  for (JobId id = 1; id <= 64; ++id) line.lanes.add(id, client(1), kSlaveOne);
  line.lanes.add(100, client(1), {LaneKind::transfer, 1});
  line.lanes.add(101, client(1), {LaneKind::transfer, 1});
  line.lanes.add(102, client(1), {LaneKind::control_word, 1});
  line.lanes.add(103, client(1), {LaneKind::broadcast, 0});
  line.lanes.add(104, client(1), {LaneKind::line, 0});
  line.lanes.add(105, client(1), {LaneKind::parameter, 2});
  line.hand_over();
  std::sort(line.given.begin(), line.given.end());
  EXPECT_EQ(line.given, (std::vector<JobId>{1, 2, 3, 4, 100, 102, 103, 104, 105}));
}

TEST(FairLanes, NoQueueOfTheMasterFillsUp) {
  cansync::CommandChannelSettings settings;
  settings.parameter_queue = 3;
  settings.transfer_queue = 1;
  settings.broadcast_queue = 1;
  Line line(settings);
  JobId next = 1;
  for (std::uint8_t slave = 0; slave < 4; ++slave) {
    for (int i = 0; i < 4; ++i) {
      for (const auto kind : {LaneKind::parameter, LaneKind::transfer, LaneKind::control_word}) {
        line.lanes.add(next++, client(1), {kind, slave});
      }
    }
  }
  for (int i = 0; i < 4; ++i) line.lanes.add(next++, client(1), {LaneKind::broadcast, 2});
  line.hand_over();
  EXPECT_EQ(line.given.size(), 3u + 1 + 4 * 4 + 1);
  // Everything still gets through, and slaves share the limit they have together.
  while (line.ended < line.given.size()) line.end_first();
  EXPECT_EQ(line.given.size(), next - 1);
}

TEST(FairLanes, WhatFindsNoRoomKeepsItsTurn) {
  FairLanes lanes(lane_limits({}));
  lanes.add(1, client(1), kSlaveOne);
  EXPECT_FALSE(lanes.hand_over([](JobId) { return false; }));
  EXPECT_TRUE(lanes.waits(1));
  std::vector<JobId> given;
  EXPECT_TRUE(lanes.hand_over([&](JobId id) {
    given.push_back(id);
    return true;
  }));
  EXPECT_EQ(given, std::vector<JobId>{1});
  EXPECT_FALSE(lanes.waits(1));
}

TEST(FairLanes, AClientHasNoMoreThanItsShareOfALane) {
  FairLanes lanes({{.in_lane = 4, .of_client = 2}});
  constexpr Lane kOnly{};
  for (JobId id = 1; id <= 5; ++id) lanes.add(id, client(1), kOnly);
  std::vector<JobId> given;
  const auto hand_over = [&] {
    EXPECT_TRUE(lanes.hand_over([&](JobId id) {
      given.push_back(id);
      return true;
    }));
  };
  hand_over();
  EXPECT_EQ(given, (std::vector<JobId>{1, 2}));
  for (JobId id = 11; id <= 13; ++id) lanes.add(id, client(2), kOnly);
  hand_over();
  EXPECT_EQ(given, (std::vector<JobId>{1, 2, 11, 12}));
  lanes.remove(12);
  hand_over();
  EXPECT_EQ(given, (std::vector<JobId>{1, 2, 11, 12, 13})) << "the first client has its share still";
  lanes.remove(4);  // waited
  lanes.remove(1);
  hand_over();
  lanes.remove(2);
  hand_over();
  EXPECT_EQ(given, (std::vector<JobId>{1, 2, 11, 12, 13, 3, 5}));
}

TEST(FairLanes, ARemovedRequestIsNeverGiven) {
  Line line;
  for (JobId id = 1; id <= 6; ++id) line.lanes.add(id, client(static_cast<std::uint8_t>(id % 2)), kSlaveOne);
  line.lanes.remove(3);
  line.lanes.remove(99);
  line.hand_over();
  while (line.ended < line.given.size()) line.end_first();
  EXPECT_EQ(line.given, (std::vector<JobId>{1, 2, 5, 4, 6}));
}

TEST(FairLanes, WhoAsksForMuchAtOnceHasNoMoreThanItsShare) {
  FairLanes lanes({{.in_lane = 400, .of_client = 64}});
  constexpr Lane kOnly{};
  for (JobId id = 1; id <= 3; ++id) lanes.add(id, client(1), kOnly, 64);
  lanes.add(4, client(2), kOnly, 100);
  for (JobId id = 11; id <= 80; ++id) lanes.add(id, client(3), kOnly);
  std::vector<JobId> given;
  const auto hand_over = [&] {
    given.clear();
    EXPECT_TRUE(lanes.hand_over([&](JobId id) {
      given.push_back(id);
      return true;
    }));
  };
  hand_over();
  EXPECT_EQ(std::count_if(given.begin(), given.end(), [](JobId id) { return id <= 3; }), 1);
  EXPECT_EQ(std::count(given.begin(), given.end(), 4u), 1) << "one that is over its share alone is given";
  EXPECT_EQ(given.size(), 66u) << "and 64 small ones";
  lanes.remove(11);
  hand_over();
  EXPECT_EQ(given, (std::vector<JobId>{75}));
  lanes.remove(1);
  hand_over();
  EXPECT_EQ(given, (std::vector<JobId>{2}));
  lanes.remove(3);  // waits
  lanes.remove(2);
  hand_over();
  EXPECT_TRUE(given.empty());
}

TEST(RequestNumbers, ANumberIsUsedOnce) {
  RequestNumbers numbers;
  EXPECT_TRUE(numbers.use(1));
  EXPECT_FALSE(numbers.use(1));
  EXPECT_TRUE(numbers.use(3));
  // Requests of different kinds may overtake each other.
  EXPECT_TRUE(numbers.use(2));
  EXPECT_FALSE(numbers.use(2));
  EXPECT_FALSE(numbers.use(3));
  EXPECT_EQ(numbers.highest(), 3u);
}

TEST(RequestNumbers, OnlySoFarBack) {
  RequestNumbers numbers;
  EXPECT_TRUE(numbers.use(5000));
  EXPECT_TRUE(numbers.use(5000 - RequestNumbers::kWidth + 1));
  EXPECT_FALSE(numbers.use(5000 - RequestNumbers::kWidth));
  EXPECT_FALSE(numbers.use(0));
  // The window moves on: what it has left counts as used, what it comes to is new.
  EXPECT_TRUE(numbers.use(5001));
  EXPECT_FALSE(numbers.use(5000 - RequestNumbers::kWidth + 1));
  EXPECT_TRUE(numbers.use(UINT64_MAX));
  EXPECT_TRUE(numbers.use(UINT64_MAX - 5));
  EXPECT_FALSE(numbers.use(5001));
}

TEST(JobNumbers, BelongToOneStartOfTheDaemon) {
  JobBook before({0x12, 0x34, 0x56, 0x78, 0x9A});
  JobBook after({0x12, 0x34, 0x56, 0x78, 0x9B});
  const JobId first = before.next_id();
  EXPECT_EQ(first, 0x0112'3456'789Au);
  EXPECT_EQ(before.next_id(), first + 1);
  EXPECT_NE(after.next_id(), first) << "`cancel`, typed for a job before a restart, ends no other one";
  EXPECT_EQ(JobBook::first_id({}), JobId{1} << 40);
  gateway::dds::DaemonIdentity highest;
  highest.fill(0xFF);
  EXPECT_LT(JobBook::first_id(highest), JobId{1} << 41) << "a whole number of JSON has 53 bits";
}

TEST(Admission, WhoIsStillLeavingAndOneClientTooManyAreToldApart) {
  JobBook book({});
  const auto leaving = book.admit({}, {nullptr, ClientTable::Admission::leaving}, 0, 0, {});
  EXPECT_EQ(leaving.denial.cause, gateway_CAUSE_IDENTITY);
  EXPECT_FALSE(leaving.client != nullptr || leaving.forget);
  const auto full = book.admit({}, {nullptr, ClientTable::Admission::full}, 0, 0, {});
  EXPECT_EQ(full.denial.cause, gateway_CAUSE_SHARED_LIMIT);
  EXPECT_TRUE(full.forget);
}

TEST(Admission, OneClientTooManyIsTakenWhenAnotherHasEnded) {
  JobBook book({});
  const auto identity = [](std::size_t number) {
    return ClientIdentity{1, static_cast<std::uint8_t>(number / 256),
                          static_cast<std::uint8_t>(number % 256)};
  };
  const auto enter = [&](std::size_t number) {
    return book.admit({identity(number), 1}, book.clients().enter(identity(number), Place{}, "tester"), 0, 0,
                      {});
  };
  for (std::size_t number = 0; number < ClientTable::kClients; ++number)
    ASSERT_NE(enter(number).client, nullptr) << number;
  EXPECT_EQ(enter(ClientTable::kClients).denial.cause, gateway_CAUSE_SHARED_LIMIT);
  book.clients().erase(identity(0));
  EXPECT_NE(enter(ClientTable::kClients).client, nullptr);
}

TEST(Stale, OldAndFutureRequestsAreToldFromOthers) {
  constexpr std::int64_t kNow = 1'700'000'000'000'000'000;
  constexpr std::chrono::milliseconds kLimit{5000};
  EXPECT_FALSE(stale(kNow, kNow, kLimit));
  EXPECT_FALSE(stale(kNow - 5'000'000'000, kNow, kLimit));
  EXPECT_FALSE(stale(kNow + 5'000'000'000, kNow, kLimit));
  const auto old = stale(kNow - 5'001'000'000, kNow, kLimit);
  ASSERT_TRUE(old);
  EXPECT_EQ(old->cause, gateway_CAUSE_STALE);
  EXPECT_NE(old->reason.find("5001 ms ago, at most 5000 ms"), std::string::npos) << old->reason;
  EXPECT_NE(old->reason.find("dds.request_max_age_ms"), std::string::npos) << old->reason;
  EXPECT_NE(old->reason.find("clocks"), std::string::npos) << old->reason;
  const auto future = stale(kNow + 5'001'000'000, kNow, kLimit);
  ASSERT_TRUE(future);
  EXPECT_EQ(future->cause, gateway_CAUSE_STALE);
  EXPECT_NE(future->reason.find("5001 ms ahead"), std::string::npos) << future->reason;
  EXPECT_TRUE(stale(INT64_MIN, kNow, kLimit));
  EXPECT_TRUE(stale(INT64_MAX, kNow, kLimit));
  EXPECT_FALSE(stale(0, kNow, std::chrono::milliseconds(0)));
}

}  // namespace
}  // namespace cansyncd
