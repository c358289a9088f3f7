#include <gtest/gtest.h>

#include "support/loop_rig.h"

/// What the realtime thread does by itself when reference values stop coming: no gateway takes part.
namespace {

using namespace cansyncd;
using namespace cansyncd::test;
using cansync::Channel;
using Code = cansync::MasterEvent::Code;
using Release = cansync::ReleaseStatus;

constexpr std::uint32_t kFirstTelegram = 0x100;
constexpr unsigned kActive = 100;  ///< the line is in active operation by then

cansync::MasterSettings settings(std::uint32_t too_old_after, std::uint32_t hold) {
  cansync::MasterSettings out = master_settings(3);
  out.process.too_old_after = too_old_after;
  out.process.hold_too_old = hold;
  return out;
}

cansync::ReferenceUpdate values(std::uint32_t intervals) {
  cansync::ReferenceUpdate update;
  update.valid_mask = 1;
  update.release_intervals = intervals;
  return update;
}

/// Interval numbers, counted from `kActive`, in which the first reference telegram was handed over.
std::vector<int> intervals(const LoopRig& rig) {
  std::vector<int> out;
  for (const can::Time at : rig.sent_on(kFirstTelegram)) {
    out.push_back(static_cast<int>(at / rig.interval) - static_cast<int>(kActive));
  }
  return out;
}

std::vector<int> count_from(int first, int last) {
  std::vector<int> out;
  for (int n = first; n <= last; ++n) out.push_back(n);
  return out;
}

std::vector<cansync::IntervalNumber> told(const LoopRig& rig, Code code) {
  std::vector<cansync::IntervalNumber> out;
  for (const EventReport& report : rig.reported<EventReport>()) {
    if (report.event.code == code) out.push_back(report.when.interval);
  }
  return out;
}

TEST(ReferencesLoop, StopAtTheIntervalAlsoWhenTheGatewayHangs) {
  LoopRig rig(virtual_time(), settings(20, 0));
  rig.gateway_reads = false;
  rig.push_at(kActive, values(1000));
  Release release;
  rig.at(kActive + 100, can::Time{0}, [&] { release = rig.snapshot().release[0]; });
  rig.run_until(kActive + 200);
  EXPECT_EQ(intervals(rig), count_from(0, 19));
  const auto too_old = told(rig, Code::references_too_old);
  ASSERT_EQ(too_old.size(), 1U);
  EXPECT_EQ(told(rig, Code::references_stopped), (std::vector{too_old[0]}));
  EXPECT_EQ(release.state, Release::State::stopped);
  EXPECT_EQ(release.cause, Release::Cause::too_old);
  EXPECT_EQ(too_old[0] - release.given, 20U);
}

TEST(ReferencesLoop, AreHeldToTheIntervalAlsoWhenTheGatewayHangs) {
  LoopRig rig(virtual_time(), settings(20, 30));
  rig.gateway_reads = false;
  rig.push_at(kActive, values(20));
  rig.run_until(kActive + 200);
  EXPECT_EQ(intervals(rig), count_from(0, 49));
  const auto held = told(rig, Code::references_held);
  ASSERT_EQ(held.size(), 1U);
  EXPECT_EQ(told(rig, Code::references_stopped), (std::vector{held[0] + 30}));
}

TEST(ReferencesLoop, AWithdrawalHoldsAsLongAsItSays) {
  LoopRig rig(virtual_time(), settings(0, 0));
  rig.push_at(kActive, values(1000));
  rig.push_at(kActive + 50, StopRelease{Channel::one, 30});
  rig.run_until(kActive + 200);
  EXPECT_EQ(intervals(rig), count_from(0, 79));
}

TEST(ReferencesLoop, AStopInTheMiddleOfAHoldIsObeyed) {
  LoopRig rig(virtual_time(), settings(20, 1000));
  rig.push_at(kActive, values(20));
  rig.push_at(kActive + 50, StopRelease{Channel::one});
  rig.run_until(kActive + 200);
  EXPECT_EQ(intervals(rig), count_from(0, 49));
}

}  // namespace
