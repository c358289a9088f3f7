#include "rt/spsc_ring.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <deque>
#include <random>
#include <thread>

namespace {

TEST(SpscRing, GivesBackInOrderWhatWasPushed) {
  rt::SpscRing<int> ring(3);
  EXPECT_TRUE(ring.try_push(1));
  EXPECT_TRUE(ring.try_push(2));
  int out = 0;
  ASSERT_TRUE(ring.try_pop(out));
  EXPECT_EQ(out, 1);
  ASSERT_TRUE(ring.try_pop(out));
  EXPECT_EQ(out, 2);
  EXPECT_FALSE(ring.try_pop(out));
  EXPECT_EQ(out, 2) << "an empty ring leaves the output alone";
}

TEST(SpscRing, HoldsExactlyItsCapacityAndRefusesTheNewest) {
  rt::SpscRing<int> ring(3);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(ring.room(), static_cast<std::size_t>(3 - i));
    EXPECT_TRUE(ring.try_push(i));
  }
  EXPECT_EQ(ring.room(), 0U);
  EXPECT_FALSE(ring.try_push(99));
  int out = -1;
  ASSERT_TRUE(ring.try_pop(out));
  EXPECT_EQ(out, 0);
  EXPECT_TRUE(ring.try_push(3));
}

TEST(SpscRing, CapacityZeroCountsAsOne) {
  rt::SpscRing<int> ring(0);
  EXPECT_EQ(ring.capacity(), 1U);
  EXPECT_TRUE(ring.try_push(1));
  EXPECT_FALSE(ring.try_push(2));
}

TEST(SpscRing, BehavesLikeABoundedQueueForAnyOrderOfCalls) {
  constexpr std::size_t kCapacity = 5;
  rt::SpscRing<std::uint32_t> ring(kCapacity);
  std::deque<std::uint32_t> model;
  std::mt19937 random(7);
  for (std::uint32_t i = 0; i < 20'000; ++i) {
    if (random() % 2 == 0) {
      const bool fits = model.size() < kCapacity;
      ASSERT_EQ(ring.try_push(i), fits);
      if (fits) model.push_back(i);
    } else {
      std::uint32_t out = 0;
      ASSERT_EQ(ring.try_pop(out), !model.empty());
      if (!model.empty()) {
        ASSERT_EQ(out, model.front());
        model.pop_front();
      }
    }
    ASSERT_EQ(ring.size(), model.size());
  }
}

/// Two words that belong together: a torn element would show.
struct Pair {
  std::uint64_t number = 0;
  std::uint64_t inverse = 0;
};

TEST(SpscRing, CrossesThreadsWithoutLossOrTearing) {
  constexpr std::uint64_t kCount = 200'000;
  rt::SpscRing<Pair> ring(64);
  std::thread producer([&ring] {
    for (std::uint64_t i = 0; i < kCount;) {
      if (ring.try_push({i, ~i})) {
        ++i;
      } else {
        std::this_thread::yield();
      }
    }
  });
  for (std::uint64_t expected = 0; expected < kCount;) {
    Pair out;
    if (!ring.try_pop(out)) {
      std::this_thread::yield();
      continue;
    }
    EXPECT_EQ(out.number, expected);
    EXPECT_EQ(out.inverse, ~expected);
    ++expected;
  }
  producer.join();
  EXPECT_EQ(ring.size(), 0U);
}

}  // namespace
