#include "cli/base/retry.h"

#include <gtest/gtest.h>

#include <set>
#include <vector>

namespace cansync::cli {
namespace {

using client::RefusalCause;
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

Reply ended(ReplyCode code, RefusalCause cause = RefusalCause::none) {
  // What is said decides nothing: these are words of another end.
  return {code, "queue full; nothing was sent; try again later", client::Speaker::daemon, cause};
}

TEST(WorthRepeating, RefusalsThatPassWhateverTheirWords) {
  const std::set<RefusalCause> passing = {
      RefusalCause::wrong_state,     RefusalCause::slave_lost,   RefusalCause::slave_held,
      RefusalCause::slaves_missing,  RefusalCause::stopping,     RefusalCause::bus_unavailable,
      RefusalCause::other_daemon,    RefusalCause::stale,        RefusalCause::queue_full,
      RefusalCause::mapping_changed, RefusalCause::client_limit, RefusalCause::shared_limit};
  for (unsigned i = 0; i <= static_cast<unsigned>(RefusalCause::shared_limit); ++i) {
    const auto cause = static_cast<RefusalCause>(i);
    for (const Effect effect : {Effect::reads, Effect::changes}) {
      EXPECT_EQ(worth_repeating(effect, ended(ReplyCode::refused, cause)), passing.contains(cause))
          << client::name(cause);
    }
  }
}

TEST(WorthRepeating, AReadingWithoutAnAnswerAndNeverAChangeOfUnknownFate) {
  const std::set<ReplyCode> unanswered = {ReplyCode::timeout, ReplyCode::no_answer, ReplyCode::slave_lost,
                                          ReplyCode::master_stopped, ReplyCode::no_reply};
  for (unsigned i = 0; i <= static_cast<unsigned>(ReplyCode::no_daemon); ++i) {
    const auto code = static_cast<ReplyCode>(i);
    if (code == ReplyCode::no_daemon) continue;
    EXPECT_EQ(worth_repeating(Effect::reads, ended(code)), unanswered.contains(code)) << client::name(code);
    EXPECT_FALSE(worth_repeating(Effect::changes, ended(code))) << client::name(code);
  }
}

TEST(WorthRepeating, WhatDidNotLeaveTheProgram) {
  EXPECT_TRUE(worth_repeating(Effect::changes, ended(ReplyCode::no_daemon)));
  EXPECT_TRUE(worth_repeating(Effect::reads, ended(ReplyCode::no_daemon)));
}

}  // namespace
}  // namespace cansync::cli
