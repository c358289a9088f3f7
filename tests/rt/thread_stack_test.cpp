#include "rt/thread_stack.h"

#include <gtest/gtest.h>
#include <pthread.h>

#include <array>
#include <thread>

namespace {

/// Stands in for libraries that keep much for each thread, as those of the sanitizers do. The realtime
/// threads of this program's other tests must start with it, too.
thread_local std::array<char, std::size_t{4} * 1024 * 1024> kept_for_each_thread;

std::size_t stack_of_a_new_thread() {
  std::size_t size = 0;
  std::thread([&size] {
    pthread_attr_t attributes;
    if (pthread_getattr_np(pthread_self(), &attributes) != 0) return;
    pthread_attr_getstacksize(&attributes, &size);
    pthread_attr_destroy(&attributes);
  }).join();
  return size;
}

TEST(ThreadStack, NewThreadsHaveTheSizeThatWasSet) {
  const std::size_t before = stack_of_a_new_thread();
  // Larger than any stack the C library may keep for reuse.
  const std::size_t wanted = before + std::size_t{1024} * 1024;
  ASSERT_TRUE(rt::set_default_stack_size(wanted));
  EXPECT_EQ(stack_of_a_new_thread(), wanted);
  ASSERT_TRUE(rt::set_default_stack_size(before));
}

TEST(ThreadStack, ARefusedSizeChangesNothing) {
  const std::size_t before = stack_of_a_new_thread();
  EXPECT_FALSE(rt::set_default_stack_size(1));
  EXPECT_EQ(stack_of_a_new_thread(), before);
}

TEST(ThreadStack, ASizeWithWhichNoThreadStartsIsRefused) {
  // The compiler must not leave out what nobody reads.
  *static_cast<volatile char*>(kept_for_each_thread.data()) = 1;
  const std::size_t before = stack_of_a_new_thread();
  EXPECT_FALSE(rt::set_default_stack_size(kept_for_each_thread.size() / 2));
  EXPECT_EQ(stack_of_a_new_thread(), before);
}

TEST(ThreadStack, CountsWhatTheProgramKeepsForEachThread) {
  *static_cast<volatile char*>(kept_for_each_thread.data()) = 1;
  EXPECT_GE(rt::thread_local_bytes(), kept_for_each_thread.size());
}

}  // namespace
