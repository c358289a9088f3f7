#include "rt/wake_signal.h"

#include <gtest/gtest.h>
#include <poll.h>

#include <atomic>
#include <chrono>
#include <thread>

namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

TEST(WakeSignal, WaitsInVainWithoutASignal) {
  rt::WakeSignal wake;
  EXPECT_FALSE(wake.wait(milliseconds(0)));
  EXPECT_FALSE(wake.wait(milliseconds(1)));
}

TEST(WakeSignal, KeepsASignalThatNobodyWaitedForAndCountsSeveralAsOne) {
  rt::WakeSignal wake;
  wake.signal();
  wake.signal();
  EXPECT_TRUE(wake.wait(milliseconds(0)));
  EXPECT_FALSE(wake.wait(milliseconds(0)));
}

TEST(WakeSignal, DescriptorIsReadableWhileASignalIsPending) {
  rt::WakeSignal wake;
  pollfd descriptor{wake.descriptor(), POLLIN, 0};
  EXPECT_EQ(::poll(&descriptor, 1, 0), 0);
  wake.signal();
  EXPECT_EQ(::poll(&descriptor, 1, 0), 1);
  wake.clear();
  EXPECT_EQ(::poll(&descriptor, 1, 0), 0);
}

TEST(WakeSignal, WakesAnotherThreadAndPublishesWhatWasWrittenBefore) {
  rt::WakeSignal wake;
  std::atomic<int> value{0};
  std::thread waker([&] {
    value.store(42, std::memory_order_relaxed);
    wake.signal();
  });
  EXPECT_TRUE(wake.wait(seconds(60)));
  waker.join();
  EXPECT_EQ(value.load(std::memory_order_relaxed), 42);
}

TEST(WakeSignal, NoSignalIsLostWhileTheWaiterTakesThem) {
  rt::WakeSignal wake;
  std::atomic<int> written{0};
  constexpr int kLast = 20'000;
  std::thread writer([&] {
    for (int i = 1; i <= kLast; ++i) {
      written.store(i, std::memory_order_relaxed);
      wake.signal();
    }
  });
  int seen = 0;
  while (seen < kLast && wake.wait(seconds(60))) seen = written.load(std::memory_order_relaxed);
  writer.join();
  EXPECT_EQ(seen, kLast);
}

}  // namespace
