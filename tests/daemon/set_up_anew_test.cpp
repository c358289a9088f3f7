#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <condition_variable>
#include <csignal>
#include <future>
#include <mutex>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "daemon/daemon.h"
#include "support/free_domain.h"

/// What the process does when a reload replaces segments, with segments that only write down what is done.
namespace cansyncd {
namespace {

using Lines = std::vector<std::string>;

/// What was done, in its order.
class Book {
 public:
  void write(const std::string& line) {
    const std::lock_guard lock(mutex_);
    lines_.push_back(line);
    changed_.notify_all();
  }
  /// Waits until it has so many lines; all of them.
  Lines wait_for(std::size_t count) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, std::chrono::minutes(1), [&] { return lines_.size() >= count; });
    return std::exchange(lines_, {});
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  Lines lines_;
};

/// What a bus's next reload meets.
struct Plan {
  bool change = true;  ///< options of the line have changed
  bool active = false;
  bool anew_fails = false;
  bool as_before_fails = false;
};

class WrittenSegment final : public Segment {
 public:
  WrittenSegment(std::string name, const Plan& plan, Book& book)
      : name_(std::move(name)), plan_(plan), book_(book) {}
  void start() override { book_.write(name_ + " starts"); }
  void end_realtime() noexcept override { book_.write(name_ + " is still"); }
  void stop() noexcept override { book_.write(name_ + " stops"); }
  bool stop_unless_active() noexcept override {
    if (!plan_.active) book_.write(name_ + " stops for its successor");
    return !plan_.active;
  }
  Heartbeat::Progress progress() const noexcept override { return {}; }
  bool record() noexcept override { return true; }
  void post(const EventText& event) override {
    if (event.severity == gateway_SEVERITY_ERROR) book_.write(name_ + " tells what was refused");
  }
  void set_surroundings(const Surroundings&) override {}
  bool in_run() const noexcept override { return false; }
  void set_pending_restart(const PendingRestart&) override {}
  ReloadPlan plan_reload(std::span<const std::string>) override {
    ReloadPlan plan{
        false, {}, {}, {"slave.2.number", "bus.name"}, [this] { book_.write(name_ + " goes on"); }};
    if (!plan_.change) return plan;
    const auto make = [this](const std::string& name, bool fails) {
      return [name, fails, &plan = plan_, &book = book_](JournalSink&) -> std::unique_ptr<Segment> {
        if (fails) throw std::runtime_error(name + " cannot be had");
        return std::make_unique<WrittenSegment>(name, plan, book);
      };
    };
    plan.needs_set_up = {"slave.2.number"};
    plan.anew = make(name_ + "'", plan_.anew_fails);
    plan.as_before = make(name_, plan_.as_before_fails);
    return plan;
  }

 private:
  std::string name_;
  const Plan& plan_;
  Book& book_;
};

class SetUpAnew : public testing::Test {
 protected:
  SetUpAnew() {
    // Signals for the process are for the thread that runs the daemon.
    sigset_t set;
    sigemptyset(&set);
    for (const int number : {SIGTERM, SIGHUP}) sigaddset(&set, number);
    pthread_sigmask(SIG_BLOCK, &set, nullptr);
    for (std::size_t i = 0; i < files_.size(); ++i) {
      const std::string name(1, static_cast<char>('a' + i));
      files_[i].path = name + ".toml";
      files_[i].daemon.bus.name = name;
      files_[i].daemon.dds.domain = domain_.get();
      files_[i].daemon.dds.partition = name;
      files_[i].make_segment = [this, name, i](JournalSink&, std::span<gateway::dds::Participant>) {
        return std::make_unique<WrittenSegment>(name, plans_[i], book_);
      };
    }
  }
  void run(std::size_t buses) {
    code_ = std::async(std::launch::async, [this, buses] { return run_daemon({files_.data(), buses}, {}); });
    (void)book_.wait_for(buses);
  }
  Lines reload(std::size_t lines) {
    kill(getpid(), SIGHUP);
    return book_.wait_for(lines);
  }
  int end() {
    kill(getpid(), SIGTERM);
    return code_.get();
  }

  std::array<Plan, 2> plans_;
  Book book_;

 private:
  FreeDomain domain_;
  std::array<LoadedConfig, 2> files_;
  std::future<int> code_;
};

TEST_F(SetUpAnew, ABusThatIsNotActiveIsReplacedAndTheOtherGoesOn) {
  plans_[1].active = true;
  run(2);
  EXPECT_EQ(reload(3), (Lines{"a stops for its successor", "a' starts", "b goes on"}));
  EXPECT_EQ(end(), exit_code::done);
  Lines ended = book_.wait_for(4);
  ASSERT_EQ(ended.size(), 4u);
  std::sort(ended.begin() + 2, ended.end());  // side by side
  EXPECT_EQ(ended, (Lines{"a' is still", "b is still", "a' stops", "b stops"}));
}

TEST_F(SetUpAnew, WhatHasNotChangedIsNotReplaced) {
  plans_[0].change = false;
  run(1);
  EXPECT_EQ(reload(1), (Lines{"a goes on"}));
  EXPECT_EQ(end(), exit_code::done);
}

TEST_F(SetUpAnew, WhatCannotBeHadIsSetUpAsBefore) {
  plans_[0].anew_fails = true;
  run(1);
  EXPECT_EQ(reload(3), (Lines{"a stops for its successor", "a starts", "a tells what was refused"}));
  EXPECT_EQ(end(), exit_code::done);
}

TEST_F(SetUpAnew, ABusThatCannotBeHadAtAllDoesNotEndTheOther) {
  plans_[0].anew_fails = true;
  plans_[0].as_before_fails = true;
  plans_[1].active = true;
  run(2);
  EXPECT_EQ(reload(2), (Lines{"a stops for its successor", "b goes on"}));
  EXPECT_EQ(reload(1), (Lines{"b goes on"}));
  EXPECT_EQ(end(), exit_code::done);
}

TEST_F(SetUpAnew, WithoutABusTheDaemonEnds) {
  plans_[0].anew_fails = true;
  plans_[0].as_before_fails = true;
  run(1);
  EXPECT_EQ(reload(1), (Lines{"a stops for its successor"}));
  EXPECT_EQ(end(), exit_code::cannot_start);
}

}  // namespace
}  // namespace cansyncd
