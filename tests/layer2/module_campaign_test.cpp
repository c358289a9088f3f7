// Random orders, frames, faults and controls against a module, by seeds; what must hold whatever happens.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <random>
#include <set>

#include "can/flagged_frames.h"
#include "layer2/module.h"

namespace layer2 {
namespace {

using can::test::data_frame;
using std::chrono::milliseconds;

/// A frame that carries the number of its order or of its reception.
can::Frame numbered(std::uint32_t identifier, std::uint32_t number) {
  return data_frame(identifier, {static_cast<std::uint8_t>(number), static_cast<std::uint8_t>(number >> 8),
                                 static_cast<std::uint8_t>(number >> 16)});
}
std::uint32_t number_of(const can::Frame& frame) {
  return frame.data[0] | frame.data[1] * 0x100u | frame.data[2] * 0x10000u;
}

/// One run: what was given, and what came of it.
class Campaign {
 public:
  explicit Campaign(unsigned seed) : random_(seed), module_(settings(seed)) { module_.begin(now_); }

  void run(unsigned steps) {
    for (unsigned i = 0; i < steps && !testing::Test::HasFailure(); ++i) step();
    finish();
  }

 private:
  static ModuleSettings settings(unsigned seed) {
    ModuleSettings settings;
    settings.station.filter.add({0x000, 0x0FF, false, FrameKinds::data_and_remote, true});
    settings.station.filter.add({0x100, 0x3FF, false, FrameKinds::data_and_remote, false});
    settings.station.queue = 5;
    settings.station.high_queue = 3;
    settings.receive_queue = 6;
    settings.receive_high_queue = 2;
    if (seed % 2 != 0) settings.station.overflow = Overflow::delete_oldest;
    if (seed % 3 == 0) settings.receive_overflow = Overflow::refuse_newest;
    settings.timers[0] = TimerSettings{.frame = data_frame(0x700, {}), .period = milliseconds(3)};
    settings.run = parse_script("Start 1\nSend 0x701 0\nWait 4\nSend 0x702 0");
    return settings;
  }

  std::size_t pick(std::size_t below) { return random_() % below; }

  void step() {
    now_ += std::chrono::microseconds(pick(700));
    module_.advance(now_);
    ASSERT_GT(module_.next_deadline(), now_);
    switch (pick(12)) {
      case 0:
      case 1:
      case 2:
        submit();
        break;
      case 3:
      case 4:
        receive();
        break;
      case 5:
      case 6:
        fetch();
        break;
      case 7:
      case 8:
        hand_over();
        break;
      case 9:
        if (!on_the_bus_.empty()) echo();
        break;
      case 10:
        if (next_order_ > 1) (void)module_.cancel(1 + pick(next_order_ - 1));
        break;
      default:
        rare();
    }
    take_answers();
  }

  void rare() {
    switch (pick(12)) {
      case 0:
        module_.controller_emptied();
        on_the_bus_.clear();
        break;
      case 1:
        module_.set_running(!module_.running(), now_);
        if (!module_.running()) forget_received();
        break;
      case 2:
        module_.clear_queues();
        forget_received();
        break;
      case 3:
        module_.reset_overflow();
        break;
      default:
        break;
    }
  }

  void submit() {
    const auto number = next_order_++;
    const Priority priority = pick(3) == 0 ? Priority::high : Priority::normal;
    const Refusal refusal = module_.submit(
        {number, numbered(0x400, static_cast<std::uint32_t>(number)), milliseconds(5 + pick(40)), priority},
        now_);
    if (refusal == Refusal::none) {
      open_.insert(number);
      priorities_[number] = priority;
    }
  }

  void receive() {
    const bool high = pick(3) == 0;
    const std::uint32_t number = next_frame_++;
    const Priority priority = high ? Priority::high : Priority::normal;
    const std::uint64_t lost = module_.receive_queue(priority).lost;
    module_.receive(numbered(high ? 0x080 : 0x200, number), now_);
    if (!module_.running()) return;
    auto& waiting = waiting_[high ? 1 : 0];
    waiting.push_back(number);
    if (module_.receive_queue(priority).lost == lost) return;
    // One was lost: it has its bit, and is the oldest or this one.
    EXPECT_TRUE(module_.receive_queue(priority).overflowed);
    if (deletes_) {
      waiting.pop_front();
    } else {
      waiting.pop_back();
    }
  }

  void fetch() {
    const auto taken = module_.take_received();
    auto& queue = !waiting_[1].empty() ? waiting_[1] : waiting_[0];
    ASSERT_EQ(taken.has_value(), !queue.empty());
    if (!taken) return;
    EXPECT_EQ(number_of(taken->frame), queue.front());  // none twice, none left out, in their order
    queue.pop_front();
  }

  void hand_over() {
    const auto frame = module_.next_frame();
    if (!frame) return;
    if (pick(8) == 0) {
      module_.held_back(Obstacle::queue_full);
      return;
    }
    module_.handed_over();
    on_the_bus_.push_back(*frame);
    if (frame->id != 0x400) return;
    const std::uint64_t number = number_of(*frame);
    EXPECT_TRUE(open_.count(number)) << "order " << number << " was answered before it was sent";
    EXPECT_TRUE(sent_.insert(number).second) << "order " << number << " was sent twice";
    std::uint64_t& last = last_sent_[priorities_[number] == Priority::high ? 1 : 0];
    EXPECT_GT(number, last);  // of one priority in the order in which they were given
    last = number;
  }

  void echo() {
    module_.echo(on_the_bus_.front(), now_);
    on_the_bus_.pop_front();
  }

  void take_answers() {
    while (const auto answer = module_.take_answer()) {
      EXPECT_EQ(open_.erase(answer->id), 1u) << "order " << answer->id << " was answered twice";
      const bool sent = sent_.count(answer->id) != 0;
      EXPECT_EQ(sent, answer->outcome == Outcome::done || answer->outcome == Outcome::no_answer)
          << answer->id;
    }
  }

  void finish() {
    module_.end();
    take_answers();
    EXPECT_TRUE(open_.empty()) << open_.size() << " orders have no answer";
  }

  void forget_received() {
    for (auto& waiting : waiting_) waiting.clear();
  }

 public:
  /// Set before `run`.
  void deletes(bool oldest) { deletes_ = oldest; }
  std::size_t sent() const { return sent_.size(); }

 private:
  std::mt19937 random_;
  Module module_;
  Time now_{0};
  bool deletes_ = true;
  std::uint64_t next_order_ = 1;
  std::uint32_t next_frame_ = 1;
  std::set<std::uint64_t> open_;
  std::set<std::uint64_t> sent_;
  std::map<std::uint64_t, Priority> priorities_;
  std::uint64_t last_sent_[2] = {0, 0};
  std::deque<std::uint32_t> waiting_[2];  ///< normal, high
  std::deque<can::Frame> on_the_bus_;
};

TEST(ModuleCampaign, NoFrameTwiceNoneLostWithoutItsBitAndInOrderWithinAPriority) {
  std::size_t sent = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    Campaign campaign(seed);
    campaign.deletes(seed % 3 != 0);
    campaign.run(4000);
    if (HasFailure()) return;
    sent += campaign.sent();
  }
  EXPECT_GT(sent, 1000u);
}

}  // namespace
}  // namespace layer2
