#include "rt/alloc_counter.h"

#include <gtest/gtest.h>
#include <pthread.h>
#include <unistd.h>

#include <cstdlib>
#include <memory>
#include <thread>
#include <vector>

namespace {

/// Keeps the optimiser from removing an allocation together with its release.
void use(void* memory) {
  asm volatile("" : : "g"(memory) : "memory");
}

TEST(AllocCounter, CountsOperatorNewOnThisThreadOnly) {
  const auto before = rt::thread_calls().allocations;
  auto single = std::make_unique<int>(1);
  use(single.get());
  std::vector<long> array(100);
  use(array.data());
  struct alignas(128) Wide {
    char bytes[128];
  };
  auto aligned = std::make_unique<Wide>();
  use(aligned.get());
  EXPECT_GE(rt::thread_calls().allocations, before + 3);

  std::uint64_t elsewhere = 0;
  std::thread other([&elsewhere] { elsewhere = rt::thread_calls().allocations; });
  const auto after_start = rt::thread_calls().allocations;
  other.join();
  EXPECT_LT(elsewhere, after_start) << "a new thread starts at zero";
}

TEST(AllocCounter, CountsTheCLibrary) {
  if (!rt::counts_c_library()) GTEST_SKIP() << "the sanitizer replaces these functions itself";
  const auto before = rt::thread_calls();
  void* memory = std::malloc(10);
  use(memory);
  void* larger = std::realloc(memory, 100);
  use(larger);
  std::free(larger);
  pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
  pthread_mutex_lock(&mutex);
  pthread_mutex_unlock(&mutex);
  int pipe_ends[2];
  ASSERT_EQ(::pipe(pipe_ends), 0);
  EXPECT_EQ(::write(pipe_ends[1], "x", 1), 1);
  ::close(pipe_ends[0]);
  ::close(pipe_ends[1]);
  const auto after = rt::thread_calls();
  EXPECT_EQ(after.allocations, before.allocations + 2);
  EXPECT_EQ(after.locks, before.locks + 1);
  EXPECT_EQ(after.writes, before.writes + 1);
}

TEST(AllocCounter, DoesNotCountWhatDoesNotAllocate) {
  const auto before = rt::thread_calls();
  int sum = 0;
  for (int i = 0; i < 100; ++i) sum += i;
  use(&sum);
  EXPECT_EQ(rt::thread_calls().allocations, before.allocations);
}

}  // namespace
