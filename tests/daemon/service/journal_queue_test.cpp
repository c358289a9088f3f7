// A journal that does not take entries holds nobody up.

#include "daemon/service/journal_queue.h"

#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "support/gateway_rig.h"

namespace cansyncd {
namespace {

using namespace std::chrono_literals;

/// A stand-in for sd_journal_sendv that takes nothing while it is shut: the caller stands in it.
class Gate {
 public:
  void shut() {
    const std::lock_guard lock(mutex_);
    open_ = false;
  }
  void open() {
    const std::lock_guard lock(mutex_);
    open_ = true;
    changed_.notify_all();
  }
  int send(const iovec* parts) {
    std::unique_lock lock(mutex_);
    ++inside_;
    changed_.notify_all();
    changed_.wait(lock, [this] { return open_; });
    --inside_;
    // The first field is MESSAGE.
    sent_.push_back(std::string(static_cast<const char*>(parts->iov_base), parts->iov_len).substr(8));
    changed_.notify_all();
    return 0;
  }
  void wait_inside() {
    std::unique_lock lock(mutex_);
    ASSERT_TRUE(changed_.wait_for(lock, 60s, [this] { return inside_ > 0; }));
  }
  void wait_sent(std::size_t count) {
    std::unique_lock lock(mutex_);
    ASSERT_TRUE(changed_.wait_for(lock, 60s, [&] { return sent_.size() >= count; }));
  }
  std::vector<std::string> sent() {
    const std::lock_guard lock(mutex_);
    return sent_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool open_ = true;
  int inside_ = 0;
  std::vector<std::string> sent_;
};

/// Opens the gate at the end of its scope, so that nobody stands in it when a test has failed.
struct OpensAtEnd {
  explicit OpensAtEnd(Gate& gate) : gate_(gate) {}
  ~OpensAtEnd() { gate_.open(); }
  OpensAtEnd(const OpensAtEnd&) = delete;
  OpensAtEnd& operator=(const OpensAtEnd&) = delete;
  Gate& gate_;
};

/// `Journal` takes a function; each test has a gate of its own.
Gate* gate = nullptr;
int send_through_gate(const iovec* parts, int) {
  return gate->send(parts);
}

class JournalQueueTest : public testing::Test {
 protected:
  JournalQueueTest() { gate = &gate_; }

  void say(const std::string& text) { queue_->write(LogPriority::info, "slave_lost", text, {}); }

  Gate gate_;
  Journal journal_{send_through_gate};
  std::optional<JournalQueue> queue_;
};

TEST_F(JournalQueueTest, EntriesGoOnInTheirOrder) {
  queue_.emplace(journal_, "two");
  for (const char* text : {"a", "b", "c"}) say(text);
  queue_.reset();
  EXPECT_EQ(gate_.sent(), (std::vector<std::string>{"a", "b", "c"}));
}

TEST_F(JournalQueueTest, WhatFindsNoRoomIsLostAndCountedOnce) {
  queue_.emplace(journal_, "two", JournalQueueLimits{4, 60s});
  gate_.shut();
  say("in the journal's hands");
  gate_.wait_inside();
  for (int i = 1; i <= 9; ++i) say(std::to_string(i));
  gate_.open();
  // The one that stood, four that waited, the loss.
  gate_.wait_sent(6);
  say("after");
  queue_.reset();
  const auto sent = gate_.sent();
  ASSERT_EQ(sent.size(), 7u);
  EXPECT_EQ(std::vector<std::string>(sent.begin(), sent.begin() + 5),
            (std::vector<std::string>{"in the journal's hands", "1", "2", "3", "4"}));
  EXPECT_EQ(sent[5].substr(0, 36), "5 entries of the journal were lost: ");
  EXPECT_EQ(sent[6], "after");
}

TEST_F(JournalQueueTest, TheEndWaitsForAJournalThatStandsNoLongerThanItsLimit) {
  queue_.emplace(journal_, "two", JournalQueueLimits{4, 50ms});
  gate_.shut();
  say("in the journal's hands");
  gate_.wait_inside();
  say("never written");
  queue_.reset();
  EXPECT_EQ(gate_.sent(), std::vector<std::string>{});
  gate_.open();
  gate_.wait_sent(1);
  EXPECT_EQ(gate_.sent(), std::vector<std::string>{"in the journal's hands"});
}

// The gateway thread tells an event and a client's change; then the journal stands.
TEST_F(JournalQueueTest, TheGatewayGoesOnWhileTheJournalStands) {
  queue_.emplace(journal_, "testbus", JournalQueueLimits{4, 60s});
  gate_.shut();
  {
    GatewayRig rig(gateway_config(), {}, {}, {}, &*queue_);
    const OpensAtEnd opens(gate_);
    for (std::uint64_t i = 0; i < 20; ++i) {
      rig.report(EventReport{moment(i), {cansync::MasterEvent::Code::slave_lost, slave(3), 0}});
      auto read = TestClient::request<cansync_ParameterRequest>(i + 1);
      read.slave = 77;  // refused, which the journal is told
      rig.client.write(read);
      ASSERT_TRUE(rig.client.reply<cansync_ParameterReply>(i + 1)) << i;
    }
    gate_.wait_inside();
  }
  queue_.reset();
  EXPECT_GT(gate_.sent().size(), 4u);
}

}  // namespace
}  // namespace cansyncd
