#include "rt/realtime_thread.h"

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <string>

namespace {

using rt::RealtimeSettings;
using rt::RealtimeThread;

/// Nothing that needs rights.
RealtimeSettings modest() {
  RealtimeSettings settings;
  settings.enforce = true;
  settings.priority = 0;
  settings.lock_memory = false;
  settings.hold_cpu_awake = false;
  return settings;
}

TEST(RealtimeThread, RunsItsWorkOnceOnAnotherThread) {
  int runs = 0;
  pthread_t worker{};
  RealtimeThread thread(modest(), [&] {
    ++runs;
    worker = pthread_self();
  });
  thread.join();
  EXPECT_EQ(runs, 1);
  EXPECT_EQ(pthread_equal(worker, pthread_self()), 0);
  EXPECT_TRUE(thread.grants().scheduling);
  EXPECT_TRUE(thread.grants().missing.empty());
}

TEST(RealtimeThread, RefusesAPriorityOrProcessorOutOfRange) {
  EXPECT_LT(rt::highest_priority(), sched_get_priority_max(SCHED_FIFO)) << "the highest is never used";
  RealtimeSettings settings = modest();
  settings.priority = sched_get_priority_max(SCHED_FIFO);
  EXPECT_THROW(RealtimeThread(settings, [] {}), std::invalid_argument);
  settings.priority = -1;
  EXPECT_THROW(RealtimeThread(settings, [] {}), std::invalid_argument);
  settings = modest();
  settings.cpu = CPU_SETSIZE;
  EXPECT_THROW(RealtimeThread(settings, [] {}), std::invalid_argument);
}

TEST(RealtimeThread, BindsToTheProcessorAskedFor) {
  cpu_set_t allowed;
  ASSERT_EQ(sched_getaffinity(0, sizeof allowed, &allowed), 0);
  RealtimeSettings settings = modest();
  settings.cpu = 0;
  while (!CPU_ISSET(static_cast<std::size_t>(settings.cpu), &allowed)) ++settings.cpu;
  int found = -1;
  RealtimeThread thread(settings, [&found] { found = sched_getcpu(); });
  thread.join();
  EXPECT_EQ(found, settings.cpu);
}

TEST(RealtimeThread, EnforcedProcessorThatDoesNotExistFailsAndNamesIt) {
  RealtimeSettings settings = modest();
  settings.cpu = CPU_SETSIZE - 1;
  bool ran = false;
  try {
    RealtimeThread thread(settings, [&ran] { ran = true; });
    FAIL() << "there is no processor " << settings.cpu;
  } catch (const rt::RealtimeError& error) {
    EXPECT_NE(std::string(error.what()).find("processor " + std::to_string(settings.cpu)), std::string::npos);
  }
  EXPECT_FALSE(ran);
}

TEST(RealtimeThread, GetsFifoSchedulingOrSaysWhatIsMissing) {
  RealtimeSettings settings = modest();
  settings.enforce = false;
  settings.priority = 10;
  int policy = -1;
  int priority = -1;
  RealtimeThread thread(settings, [&] {
    sched_param parameters{};
    pthread_getschedparam(pthread_self(), &policy, &parameters);
    priority = parameters.sched_priority;
  });
  thread.join();
  if (thread.grants().scheduling) {
    EXPECT_EQ(policy, SCHED_FIFO);
    EXPECT_EQ(priority, 10);
  } else {
    EXPECT_EQ(policy, SCHED_OTHER);
    ASSERT_EQ(thread.grants().missing.size(), 1U);
    EXPECT_NE(thread.grants().missing[0].find("LimitRTPRIO="), std::string::npos);
  }
}

/// Starts a thread without any right in a process of its own; the exit code tells how it went.
enum class Ending : int { granted = 10, refused = 11, named = 12 };

template <class Work>
int in_child_without_rights(Work work) {
  const pid_t child = fork();
  if (child == 0) {
    const rlimit none{0, 0};
    setrlimit(RLIMIT_RTPRIO, &none);
    setrlimit(RLIMIT_MEMLOCK, &none);
    if (geteuid() == 0 && setuid(65534) != 0) _exit(99);
    _exit(static_cast<int>(work()));
  }
  int status = 0;
  if (child < 0 || waitpid(child, &status, 0) != child || !WIFEXITED(status)) return -1;
  return WEXITSTATUS(status);
}

TEST(RealtimeThread, HoldsTheProcessorAwakeInBothModesWhenItMay) {
  for (const bool enforce : {true, false}) {
    RealtimeSettings settings = modest();
    settings.enforce = enforce;
    settings.hold_cpu_awake = true;
    RealtimeThread thread(settings, [] {});
    const bool may = access("/dev/cpu_dma_latency", W_OK) == 0;
    EXPECT_EQ(thread.grants().cpu_held_awake, may) << "never enforced, always asked for";
    EXPECT_EQ(thread.grants().missing.empty(), may);
  }
}

TEST(RealtimeThread, EnforceFailsWithoutRightsAndNamesBothLimitsAndNothingElse) {
  const int ending = in_child_without_rights([] {
    RealtimeSettings settings;
    settings.hold_cpu_awake = true;
    try {
      RealtimeThread thread(settings, [] {});
    } catch (const rt::RealtimeError& error) {
      const std::string text = error.what();
      const bool named =
          text.find("LimitRTPRIO=60") != std::string::npos && text.find("LimitMEMLOCK=") != std::string::npos;
      // Not granted either, but no reason to refuse.
      const bool more = text.find("cpu_dma_latency") != std::string::npos;
      return named && !more ? Ending::named : Ending::refused;
    }
    return Ending::granted;
  });
  EXPECT_EQ(ending, static_cast<int>(Ending::named));
}

TEST(RealtimeThread, IgnoreRunsWithoutRightsAndReportsWhatIsMissing) {
  const int ending = in_child_without_rights([] {
    RealtimeSettings settings;
    settings.enforce = false;
    bool ran = false;
    RealtimeThread thread(settings, [&ran] { ran = true; });
    thread.join();
    const rt::Grants& grants = thread.grants();
    const bool reported = !grants.scheduling && !grants.memory_locked && grants.missing.size() >= 2;
    return ran && reported ? Ending::named : Ending::refused;
  });
  EXPECT_EQ(ending, static_cast<int>(Ending::named));
}

}  // namespace
