#include "layer2/bounded_queue.h"

#include <gtest/gtest.h>

#include <deque>
#include <random>

namespace layer2 {
namespace {

TEST(BoundedQueue, L15TheOldestIsDeletedAndTheBitStaysUntilItIsReset) {
  BoundedQueue<int> queue(3, Overflow::delete_oldest);
  for (const int number : {1, 2, 3}) EXPECT_FALSE(queue.push(number).deleted);
  EXPECT_FALSE(queue.overflowed());
  const auto pushed = queue.push(4);
  EXPECT_TRUE(pushed.taken);
  EXPECT_EQ(pushed.deleted, 1);
  for (const int number : {2, 3, 4}) EXPECT_EQ(queue.pop(), number);
  EXPECT_TRUE(queue.overflowed());
  queue.reset_overflow();
  EXPECT_FALSE(queue.overflowed());
  EXPECT_EQ(queue.lost(), 1u);
}

TEST(BoundedQueue, L48TheNewestIsRefused) {
  BoundedQueue<int> queue(2, Overflow::refuse_newest);
  EXPECT_TRUE(queue.push(1).taken);
  EXPECT_TRUE(queue.push(2).taken);
  EXPECT_FALSE(queue.push(3).taken);
  EXPECT_TRUE(queue.overflowed());
  EXPECT_EQ(queue.pop(), 1);
  EXPECT_EQ(queue.pop(), 2);
  EXPECT_TRUE(queue.empty());
}

TEST(BoundedQueue, L26HalfFullIsHalfOfTheRoom) {
  BoundedQueue<int> queue(5);
  for (const int number : {1, 2}) (void)queue.push(number);
  EXPECT_FALSE(queue.half_full());
  (void)queue.push(3);
  EXPECT_TRUE(queue.half_full());
}

// Against the standard library's, in every order of what can happen, around the end of the ring.
TEST(BoundedQueue, L14DoesWhatAQueueDoes) {
  std::mt19937 random(17);
  for (const Overflow rule : {Overflow::delete_oldest, Overflow::refuse_newest}) {
    BoundedQueue<int> queue(7, rule);
    std::deque<int> model;
    std::uint64_t lost = 0;
    for (int step = 0; step < 20000; ++step) {
      const auto what = random() % 8;
      if (what < 4) {
        std::size_t at = what == 0 ? random() % (model.size() + 1) : model.size();
        const auto pushed = queue.insert(at, step);
        if (model.size() == 7) {
          ++lost;
          ASSERT_EQ(pushed.taken, rule == Overflow::delete_oldest);
          if (!pushed.taken) continue;
          ASSERT_EQ(pushed.deleted, model.front());
          model.pop_front();
          at -= at == 0 ? 0 : 1;
        }
        model.insert(model.begin() + static_cast<std::ptrdiff_t>(at), step);
      } else if (what < 6 && !model.empty()) {
        ASSERT_EQ(queue.pop(), model.front());
        model.pop_front();
      } else if (!model.empty()) {
        const std::size_t at = random() % model.size();
        queue.erase(at);
        model.erase(model.begin() + static_cast<std::ptrdiff_t>(at));
      }
      ASSERT_EQ(queue.size(), model.size());
      ASSERT_EQ(queue.lost(), lost);
      for (std::size_t i = 0; i < model.size(); ++i) ASSERT_EQ(queue[i], model[i]);
    }
  }
}

}  // namespace
}  // namespace layer2
