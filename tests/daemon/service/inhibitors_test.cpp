#include "daemon/service/inhibitors.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <condition_variable>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace cansyncd {
namespace {

using std::chrono::seconds;
using Lines = std::vector<std::string>;

constexpr const char* kBlock =
    "block sleep:idle:handle-power-key:handle-suspend-key:handle-hibernate-key:handle-lid-switch";
constexpr const char* kDelay = "delay shutdown";

/// A logind that grants or refuses, and knows which of its locks are still open.
class WrittenLogind final : public Logind {
 public:
  std::string inhibit(std::string_view what, std::string_view mode, sys::Descriptor& lock) override {
    const std::string name = std::string(mode) + " " + std::string(what);
    calls.push_back(name);
    if (!refusal.empty() && (refused_mode.empty() || refused_mode == mode)) return refusal;
    std::array<int, 2> ends{};
    EXPECT_EQ(::pipe2(ends.data(), O_CLOEXEC), 0);
    lock.reset(ends[1]);
    locks_.emplace_back(name, std::make_unique<sys::Descriptor>(ends[0]));
    return {};
  }
  bool shuts_down_within(std::chrono::milliseconds) override { return false; }

  /// As logind does it: the other end of a lock that was given back has hung up.
  Lines held() const {
    Lines names;
    for (const auto& [name, end] : locks_) {
      pollfd look{end->number(), POLLIN, 0};
      if (::poll(&look, 1, 0) == 0) names.push_back(name);
    }
    return names;
  }

  Lines calls;
  std::string refusal;
  std::string refused_mode;  ///< empty: both

 private:
  std::vector<std::pair<std::string, std::unique_ptr<sys::Descriptor>>> locks_;
};

class LineInRun : public testing::Test {
 protected:
  InhibitorState step(bool in_run, seconds later = seconds(1)) { return locks_.step(in_run, now_ += later); }

  WrittenLogind logind_;
  InhibitorLocks locks_{logind_};
  std::chrono::steady_clock::time_point now_{std::chrono::hours(1)};
};

TEST_F(LineInRun, KeepsTheComputerAwakeAndAShutdownWaiting) {
  EXPECT_EQ(step(false), InhibitorState());
  EXPECT_EQ(logind_.calls, Lines());
  EXPECT_EQ(step(true), (InhibitorState{true, ""}));
  EXPECT_EQ(logind_.held(), Lines({kBlock, kDelay}));
  EXPECT_EQ(step(true), (InhibitorState{true, ""}));
  EXPECT_EQ(logind_.calls.size(), 2u) << "each is taken once";
  EXPECT_EQ(step(false), InhibitorState());
  EXPECT_EQ(logind_.held(), Lines());
  EXPECT_EQ(step(true), (InhibitorState{true, ""}));
  EXPECT_EQ(logind_.held(), Lines({kBlock, kDelay}));
}

TEST_F(LineInRun, ARefusalIsTriedAgainLaterAndNotSooner) {
  logind_.refusal = "Access denied";
  EXPECT_EQ(step(true), (InhibitorState{false, "Access denied"}));
  EXPECT_EQ(step(true, InhibitorLocks::kRetry - seconds(1)), (InhibitorState{false, "Access denied"}));
  EXPECT_EQ(logind_.calls.size(), 2u);
  logind_.refusal.clear();
  EXPECT_EQ(step(true), (InhibitorState{true, ""}));
  EXPECT_EQ(logind_.held(), Lines({kBlock, kDelay}));
}

TEST_F(LineInRun, WhatIsGrantedIsHeldThoughTheOtherIsRefused) {
  logind_.refusal = "Access denied";
  logind_.refused_mode = "block";
  EXPECT_EQ(step(true), (InhibitorState{false, "Access denied"}));
  EXPECT_EQ(logind_.held(), Lines({kDelay}));
  EXPECT_EQ(step(false), InhibitorState());
  EXPECT_EQ(logind_.held(), Lines());
  // A line that comes again is asked for at once.
  logind_.refusal.clear();
  EXPECT_EQ(step(true), (InhibitorState{true, ""}));
}

/// One that begins to shut down when the line has its locks.
class EndingLogind final : public Logind {
 public:
  std::string inhibit(std::string_view, std::string_view, sys::Descriptor& lock) override {
    lock.reset(::open("/dev/null", O_CLOEXEC));
    ++taken_;
    return {};
  }
  bool shuts_down_within(std::chrono::milliseconds) override {
    return taken_ == 2 && std::exchange(taken_, 3) == 2;
  }

 private:
  int taken_ = 0;
};

TEST(InhibitorThread, SaysOnceThatTheComputerShutsDown) {
  std::mutex mutex;
  std::condition_variable changed;
  int said = 0;
  Inhibitors inhibitors(std::make_unique<EndingLogind>(), [&] {
    const std::lock_guard lock(mutex);
    ++said;
    changed.notify_all();
  });
  inhibitors.set_in_run(true);
  std::unique_lock lock(mutex);
  EXPECT_TRUE(changed.wait_for(lock, std::chrono::minutes(1), [&] { return said == 1; }));
  lock.unlock();
  EXPECT_EQ(inhibitors.state(), (InhibitorState{true, ""}));
}

TEST(InhibitorThread, WithoutLogindNothingIsDone) {
  Inhibitors inhibitors(nullptr, [] { FAIL(); });
  inhibitors.set_in_run(true);
  EXPECT_EQ(inhibitors.state(), InhibitorState());
}

}  // namespace
}  // namespace cansyncd
