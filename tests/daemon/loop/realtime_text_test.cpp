#include "daemon/loop/realtime_text.h"

#include <gtest/gtest.h>

namespace {

using cansyncd::realtime_text;

TEST(RealtimeText, NamesEverythingThatWasGranted) {
  rt::RealtimeSettings settings;
  settings.cpu = 1;
  rt::Grants grants{
      .scheduling = true, .affinity = true, .memory_locked = true, .cpu_held_awake = true, .missing = {}};
  EXPECT_EQ(
      realtime_text(settings, grants, "6.1.0-37-rt-amd64 (PREEMPT_RT)"),
      "realtime thread: SCHED_FIFO priority 60, processor 1, memory locked, cpu_dma_latency held at 0 us, "
      "kernel 6.1.0-37-rt-amd64 (PREEMPT_RT)");
}

TEST(RealtimeText, NamesEverythingThatWasNot) {
  rt::RealtimeSettings settings;
  settings.cpu = 7;
  EXPECT_EQ(realtime_text(settings, {}, "k"),
            "realtime thread: SCHED_OTHER (priority 60 not granted), any processor (7 not granted), memory "
            "not locked (not granted), cpu_dma_latency not held (not granted), kernel k");
}

TEST(RealtimeText, NamesWhatWasNotAskedFor) {
  rt::RealtimeSettings settings;
  settings.priority = 0;
  settings.lock_memory = false;
  settings.hold_cpu_awake = false;
  const rt::Grants grants{
      .scheduling = true, .affinity = true, .memory_locked = true, .cpu_held_awake = true, .missing = {}};
  EXPECT_EQ(realtime_text(settings, grants, "k"),
            "realtime thread: SCHED_OTHER as configured, any processor, memory not locked as configured, "
            "cpu_dma_latency not asked for, kernel k");
}

}  // namespace
