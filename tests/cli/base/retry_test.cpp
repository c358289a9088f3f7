#include "cli/base/retry.h"

#include <gtest/gtest.h>

#include <vector>

#include "daemon/cansync/texts/refusal_text.h"
#include "daemon/desk/limits_text.h"
#include "daemon/desk/rejections.h"

namespace cansync::cli {
namespace {

using client::Reply;
using client::ReplyCode;
using std::chrono::milliseconds;

/// A clock that only pauses move, and what was said.
struct FakeWorld {
  Retry::Clock::time_point now{std::chrono::hours(1)};
  std::vector<std::int64_t> pauses;  // ms
  std::vector<std::string> said;
  bool interrupted = false;

  Retry::World world() {
    return {[this] { return now; },
            [this](Retry::Clock::time_point until) {
              pauses.push_back(std::chrono::duration_cast<milliseconds>(until - now).count());
              now = until;
              return interrupted;
            },
            [this](std::string_view text) { said.emplace_back(text); }};
  }
};

TEST(RetryTime, PausesGrowAndEndWithTheTime) {
  FakeWorld fake;
  {
    Retry retry(3.0, fake.world());
    while (retry.failed("queue full") == Retry::Verdict::again) continue;
  }
  EXPECT_EQ(fake.pauses, (std::vector<std::int64_t>{100, 200, 400, 800, 1000, 500}));
  EXPECT_EQ(fake.said, (std::vector<std::string>{"trying again for 3 s: queue full", "tried again 6 times"}));
}

TEST(RetryTime, CountsFromTheFirstFailureWhateverTheAttemptsTake) {
  FakeWorld fake;
  Retry retry(2.0, fake.world());
  fake.now += std::chrono::minutes(1);
  EXPECT_EQ(retry.failed("a"), Retry::Verdict::again);
  fake.now += milliseconds(2500);
  EXPECT_EQ(retry.failed("b"), Retry::Verdict::over);
}

TEST(RetryTime, WithoutItNothingIsTriedAgainOrSaid) {
  FakeWorld fake;
  {
    Retry retry(0.0, fake.world());
    EXPECT_EQ(retry.failed("a"), Retry::Verdict::over);
  }
  EXPECT_TRUE(fake.said.empty());
  EXPECT_TRUE(fake.pauses.empty());
}

TEST(RetryTime, AnInterruptEndsIt) {
  FakeWorld fake;
  fake.interrupted = true;
  Retry retry(10.0, fake.world());
  EXPECT_EQ(retry.failed("a"), Retry::Verdict::interrupted);
}

constexpr ReplyCode kCodes[] = {ReplyCode::done,
                                ReplyCode::refused,
                                ReplyCode::slave_error,
                                ReplyCode::timeout,
                                ReplyCode::no_answer,
                                ReplyCode::word_expected,
                                ReplyCode::doubleword_expected,
                                ReplyCode::value_too_wide,
                                ReplyCode::cancelled,
                                ReplyCode::master_stopped,
                                ReplyCode::slave_lost,
                                ReplyCode::no_reply};

TEST(WorthRepeating, AChangeOfUnknownFateNever) {
  for (const ReplyCode code : kCodes)
    EXPECT_FALSE(worth_repeating(Effect::changes,
                                 {code, "the daemon is gone; whether the request was done is not known"}))
        << client::name(code);
}

TEST(WorthRepeating, AReadingWithoutAnAnswer) {
  for (const ReplyCode code : kCodes) {
    const bool unanswered = code == ReplyCode::timeout || code == ReplyCode::no_answer ||
                            code == ReplyCode::slave_lost || code == ReplyCode::master_stopped ||
                            code == ReplyCode::no_reply;
    EXPECT_EQ(worth_repeating(Effect::reads, {code, "whatever"}), unanswered) << client::name(code);
  }
}

TEST(WorthRepeating, WhatDidNotLeaveTheProgram) {
  const Reply unsent{ReplyCode::no_reply, "no daemon is there (DDS domain 0); nothing was sent"};
  EXPECT_TRUE(worth_repeating(Effect::changes, unsent));
  EXPECT_TRUE(worth_repeating(Effect::reads, unsent));
  EXPECT_TRUE(
      worth_repeating(Effect::changes, {ReplyCode::refused,
                                        "the daemon did not take the request within 1 s, nothing was sent; "
                                        "wait for open requests to end"}));
}

/// What the daemon says of each refusal, in its own words.
TEST(WorthRepeating, RefusalsThatPass) {
  cansyncd::Config config;
  for (unsigned i = 0; i < 4; ++i) config.master.slaves[i].configured = true;
  config.slaves[1].name = "queue full";  // a name must not look like a reason
  const cansyncd::RefusalContext context{State::setting_up_master, 5000, {0x7}, {0x3}};
  ControlWordRequest request;
  request.slave = *SlaveNumber::from(1);
  for (unsigned i = static_cast<unsigned>(Refusal::slave_not_configured);
       i <= static_cast<unsigned>(Refusal::not_held); ++i) {
    const auto refusal = static_cast<Refusal>(i);
    const std::string reason = cansyncd::refusal_text(refusal, request, config, context);
    const bool passes = refusal == Refusal::queue_full || refusal == Refusal::wrong_state ||
                        refusal == Refusal::slaves_missing || refusal == Refusal::slave_lost ||
                        refusal == Refusal::slave_held;
    EXPECT_EQ(worth_repeating(Effect::changes, {ReplyCode::refused, reason}), passes) << reason;
    EXPECT_EQ(worth_repeating(Effect::reads, {ReplyCode::refused, reason}), passes) << reason;
  }
}

TEST(WorthRepeating, WhatTheDaemonHasNoRoomFor) {
  const auto worth = [](const std::string& reason) {
    return worth_repeating(Effect::changes, {ReplyCode::refused, reason});
  };
  EXPECT_TRUE(worth(cansyncd::too_many_clients(64, 64).reason));
  EXPECT_TRUE(worth(cansyncd::too_many_requests(32, 32).reason));
  EXPECT_TRUE(worth(cansyncd::too_many_bytes(10, 90, 95).reason));
  EXPECT_FALSE(worth(cansyncd::too_many_bytes_of_client(10, 90, 95).reason))
      << "this program has no other open";
}

TEST(WorthRepeating, WhatCameTooLate) {
  const auto reason = cansyncd::stale(0, 3'000'000'000, std::chrono::seconds(2));
  ASSERT_TRUE(reason);
  EXPECT_TRUE(worth_repeating(Effect::changes, {ReplyCode::refused, reason->reason}));
}

}  // namespace
}  // namespace cansync::cli
