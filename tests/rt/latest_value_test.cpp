#include "rt/latest_value.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <thread>

namespace {

TEST(LatestValue, HasNothingBeforeTheFirstWrite) {
  rt::LatestValue<int> latest;
  int out = 5;
  EXPECT_FALSE(latest.read(out));
  EXPECT_EQ(out, 5);
}

TEST(LatestValue, GivesTheNewestOnce) {
  rt::LatestValue<int> latest;
  latest.write(1);
  latest.write(2);
  latest.write(3);
  int out = 0;
  ASSERT_TRUE(latest.read(out));
  EXPECT_EQ(out, 3);
  EXPECT_FALSE(latest.read(out)) << "read already";
  latest.write(4);
  ASSERT_TRUE(latest.read(out));
  EXPECT_EQ(out, 4);
}

/// As large as a real snapshot, all words equal: a torn value would show.
using Wide = std::array<std::uint64_t, 64>;

TEST(LatestValue, CrossesThreadsWholeAndNeverGoesBack) {
  constexpr std::uint64_t kCount = 100'000;
  rt::LatestValue<Wide> latest;
  std::atomic<bool> first_read{false};
  std::thread writer([&] {
    Wide value;
    for (std::uint64_t i = 1; i <= kCount; ++i) {
      value.fill(i);
      latest.write(value);
      // Both threads are sure to overlap: the second half waits for the reader.
      if (i == kCount / 2) first_read.wait(false);
    }
  });
  std::uint64_t last = 0;
  while (last < kCount) {
    Wide value;
    if (!latest.read(value)) {
      std::this_thread::yield();
      continue;
    }
    for (const std::uint64_t word : value) ASSERT_EQ(word, value[0]);
    ASSERT_GT(value[0], last);
    last = value[0];
    first_read = true;
    first_read.notify_one();
  }
  writer.join();
}

}  // namespace
