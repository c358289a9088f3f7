#include "cansync/process_data/release_status.h"
#include "master_rig.h"

/// How long reference values are released: age, hold and withdrawal, exact to the interval.
namespace cansync::test {
namespace {

using State = ReleaseStatus::State;
using Cause = ReleaseStatus::Cause;
using Code = MasterEvent::Code;

std::unique_ptr<MasterRig> line(std::uint32_t too_old_after, std::uint32_t hold_too_old) {
  MasterSettings settings = settings_for(2);
  settings.startup.status_period = Duration(0);
  settings.process.too_old_after = too_old_after;
  settings.process.hold_too_old = hold_too_old;
  auto rig = std::make_unique<MasterRig>(settings);
  rig->activate();
  return rig;
}

ReferenceUpdate values(std::uint32_t first, std::uint32_t intervals) {
  return {.value = {first}, .valid_mask = 1, .release_intervals = intervals};
}

/// Low word of the first value in this interval's WRC1; nothing when it is left out.
std::optional<std::uint16_t> released(MasterRig& rig) {
  rig.step();
  for (const Telegram& telegram : rig.sent) {
    if (const auto* reference = std::get_if<ReferenceTelegram>(&telegram)) return reference->word[0];
  }
  return std::nullopt;
}

/// Intervals in a row, from the next on, in which WRC1 carries `value`; the one after them is over too.
unsigned row_of(MasterRig& rig, std::uint16_t value) {
  unsigned count = 0;
  while (count < 100 && released(rig) == value) ++count;
  return count;
}

TEST(ReferenceRelease, ValuesGrowTooOldExactlyAfterTheirIntervals) {
  auto rig = line(5, 0);
  ASSERT_EQ(rig->master.submit(values(7, 1000)), Refusal::none);
  EXPECT_EQ(row_of(*rig, 7), 5u);
  EXPECT_EQ(rig->told.count(Code::references_too_old), 1u);
  EXPECT_EQ(rig->told.count(Code::references_stopped), 1u);
  const ReleaseStatus& status = rig->master.release(Channel::one);
  EXPECT_EQ(status.state, State::stopped);
  EXPECT_EQ(status.cause, Cause::too_old);
  EXPECT_EQ(status.too_old, 1u);
  rig->run(50);
  EXPECT_EQ(rig->told.count(Code::references_too_old), 1u) << "on the edge alone";
  EXPECT_EQ(rig->master.release(Channel::two).too_old, 0u) << "nothing was ever given";
}

TEST(ReferenceRelease, WhatWasGivenBeforeTheBusWasLostIsNotSentWhenItIsBack) {
  auto rig = line(0, 0);
  ReferenceUpdate later = values(8, 1000);
  later.from_interval = rig->next_interval + 10;
  ASSERT_EQ(rig->master.submit(values(7, 1000)), Refusal::none);
  ASSERT_EQ(rig->master.submit(later), Refusal::none);
  EXPECT_EQ(released(*rig), 7);
  rig->master.bus_lost();
  for (int i = 0; i < 50; ++i) EXPECT_EQ(released(*rig), std::nullopt);
  EXPECT_EQ(rig->master.release(Channel::one).cause, Cause::bus_lost);
  EXPECT_EQ(rig->told.count(Code::references_stopped), 1u);
  ASSERT_EQ(rig->master.submit(values(9, 5)), Refusal::none);
  EXPECT_EQ(row_of(*rig, 9), 5u);
}

TEST(ReferenceRelease, SkippedIntervalsCountAsUsed) {
  auto rig = line(0, 0);
  ASSERT_EQ(rig->master.submit(values(7, 10)), Refusal::none);
  EXPECT_EQ(released(*rig), 7);
  rig->next_interval += 6;
  EXPECT_EQ(row_of(*rig, 7), 3u);
  ASSERT_EQ(rig->master.submit(values(8, 10)), Refusal::none);
  EXPECT_EQ(released(*rig), 8);
  rig->next_interval += 1000;
  EXPECT_EQ(released(*rig), std::nullopt);
}

TEST(ReferenceRelease, ValuesForIntervalsThatWereSkippedAreNeverReleased) {
  auto rig = line(0, 0);
  ReferenceUpdate over = values(7, 3);
  over.from_interval = rig->next_interval + 5;
  ReferenceUpdate partly = values(8, 10);
  partly.from_interval = rig->next_interval + 8;
  ASSERT_EQ(rig->master.submit(over), Refusal::none);
  ASSERT_EQ(rig->master.submit(partly), Refusal::none);
  EXPECT_EQ(released(*rig), std::nullopt);
  rig->next_interval = over.from_interval + 3;
  EXPECT_EQ(row_of(*rig, 8), 10u);
  ReferenceUpdate late = values(9, 10);
  late.from_interval = rig->next_interval + 5;
  ASSERT_EQ(rig->master.submit(late), Refusal::none);
  rig->next_interval = late.from_interval + 4;
  EXPECT_EQ(row_of(*rig, 9), 6u);
}

TEST(ReferenceRelease, NewValuesInTimeKeepItGoing) {
  auto rig = line(5, 0);
  for (std::uint16_t n = 0; n < 20; ++n) {
    ASSERT_EQ(rig->master.submit(values(n, 5)), Refusal::none);
    for (int i = 0; i < 5; ++i) EXPECT_EQ(released(*rig), n);
  }
  EXPECT_EQ(rig->told.count(Code::references_too_old), 0u);
  EXPECT_EQ(rig->master.release(Channel::one).updates, 20u);
}

TEST(ReferenceRelease, AgeIsCountedInIntervalNumbersAlsoWhenEdgesWereMissed) {
  auto rig = line(10, 0);
  ASSERT_EQ(rig->master.submit(values(7, 1000)), Refusal::none);
  EXPECT_EQ(released(*rig), 7);
  rig->next_interval += 8;
  EXPECT_EQ(released(*rig), 7) << "9 intervals old";
  EXPECT_EQ(released(*rig), std::nullopt) << "10 intervals old";
}

TEST(ReferenceRelease, AgeBeginsWithTheIntervalTheValuesAreFor) {
  auto rig = line(5, 0);
  auto later = values(7, 1000);
  later.from_interval = rig->next_interval + 20;
  rig->step();
  ASSERT_EQ(rig->master.submit(later), Refusal::none);
  for (int i = 0; i < 19; ++i) EXPECT_EQ(released(*rig), std::nullopt);
  EXPECT_EQ(row_of(*rig, 7), 5u);
}

TEST(ReferenceRelease, ValuesUsedUpEarlierAreTooOldAtTheirTimeAllTheSame) {
  auto rig = line(5, 3);
  ASSERT_EQ(rig->master.submit(values(7, 2)), Refusal::none);
  EXPECT_EQ(row_of(*rig, 7), 2u);
  EXPECT_EQ(rig->master.release(Channel::one).cause, Cause::used_up);
  EXPECT_EQ(rig->told.count(Code::references_too_old), 0u);
  rig->run(2);
  EXPECT_EQ(rig->told.count(Code::references_too_old), 0u);
  EXPECT_EQ(released(*rig), std::nullopt) << "a release that has ended is not taken up again";
  EXPECT_EQ(rig->told.count(Code::references_too_old), 1u);
  EXPECT_EQ(rig->told.count(Code::references_held), 0u);
  EXPECT_EQ(row_of(*rig, 7), 0u);
}

TEST(ReferenceRelease, TooOldValuesAreHeldForExactlyTheIntervalsSet) {
  for (const std::uint32_t given : {5u, 1000u}) {  // used up in the same interval, and not
    auto rig = line(5, 3);
    ASSERT_EQ(rig->master.submit(values(7, given)), Refusal::none);
    for (int i = 0; i < 5; ++i) ASSERT_EQ(released(*rig), 7);
    EXPECT_EQ(rig->told.count(Code::references_held), 0u);
    ASSERT_EQ(released(*rig), 7);
    EXPECT_EQ(rig->told.count(Code::references_too_old), 1u);
    EXPECT_EQ(rig->told.count(Code::references_held), 1u);
    EXPECT_EQ(rig->master.release(Channel::one).state, State::held);
    EXPECT_EQ(row_of(*rig, 7), 2u);
    EXPECT_EQ(rig->told.count(Code::references_stopped), 1u);
    EXPECT_EQ(rig->master.release(Channel::one).state, State::stopped);
    EXPECT_EQ(rig->master.release(Channel::one).cause, Cause::too_old);
    EXPECT_EQ(row_of(*rig, 7), 0u);
  }
}

TEST(ReferenceRelease, NewValuesEndAHold) {
  auto rig = line(5, 10);
  ASSERT_EQ(rig->master.submit(values(7, 5)), Refusal::none);
  rig->run(8);
  ASSERT_EQ(rig->master.release(Channel::one).state, State::held);
  ASSERT_EQ(rig->master.submit(values(8, 2)), Refusal::none);
  EXPECT_EQ(row_of(*rig, 8), 2u) << "as long as they say, not as long as the hold";
  EXPECT_EQ(rig->told.count(Code::references_released), 2u);
  EXPECT_EQ(rig->told.count(Code::references_held), 1u);
}

TEST(ReferenceRelease, AWithdrawnReleaseGoesOnForTheHoldAndNoLonger) {
  auto rig = line(0, 0);
  ASSERT_EQ(rig->master.submit(values(7, 1000)), Refusal::none);
  auto later = values(9, 1);
  later.from_interval = rig->next_interval + 5;
  ASSERT_EQ(rig->master.submit(later), Refusal::none);
  rig->run(2);
  rig->master.stop_release(Channel::one, 6);
  EXPECT_EQ(released(*rig), 7);
  EXPECT_EQ(released(*rig), 7);
  rig->master.stop_release(Channel::one, 6);  // for a second cause: not longer
  EXPECT_EQ(row_of(*rig, 7), 4u) << "and what was given for later is forgotten";
  EXPECT_EQ(rig->master.release(Channel::one).cause, Cause::withdrawn);
  EXPECT_EQ(rig->told.count(Code::references_held), 1u);
  rig->master.stop_release(Channel::one, 6);
  EXPECT_EQ(row_of(*rig, 7), 0u) << "it has stopped";
}

TEST(ReferenceRelease, AReleaseThatWasUsedUpInThisIntervalCanStillBeHeld) {
  auto rig = line(0, 0);
  ASSERT_EQ(rig->master.submit(values(7, 2)), Refusal::none);
  rig->run(2);
  rig->master.stop_release(Channel::one, 3);
  EXPECT_EQ(row_of(*rig, 7), 3u);
}

TEST(ReferenceRelease, WithdrawalWithoutHoldEndsAHoldAtOnce) {
  auto rig = line(5, 1000);
  ASSERT_EQ(rig->master.submit(values(7, 5)), Refusal::none);
  rig->run(10);
  ASSERT_EQ(rig->master.release(Channel::one).state, State::held);
  rig->master.stop_release(Channel::one);
  EXPECT_EQ(released(*rig), std::nullopt);
}

TEST(ReferenceRelease, LeavingActiveOperationEndsAHold) {
  auto rig = line(5, 1000);
  ASSERT_EQ(rig->master.submit(values(7, 5)), Refusal::none);
  rig->run(10);
  ASSERT_EQ(rig->master.control(ControlCommand::cold_restart), Refusal::none);
  rig->activate();
  EXPECT_EQ(released(*rig), std::nullopt);
  EXPECT_EQ(rig->master.release(Channel::one).cause, Cause::none);
}

TEST(ReferenceRelease, AnotherGiverReplacesWhatWasGivenForLater) {
  auto rig = line(0, 0);
  auto later = values(1, 1);
  later.from_interval = rig->next_interval + 3;
  ASSERT_EQ(rig->master.submit(later), Refusal::none);
  auto other = values(2, 10);
  other.takes_over = true;
  ASSERT_EQ(rig->master.submit(other), Refusal::none);
  EXPECT_EQ(row_of(*rig, 2), 10u);
}

}  // namespace
}  // namespace cansync::test
