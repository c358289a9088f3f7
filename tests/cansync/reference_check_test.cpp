// What reference values may be: minimum, maximum, step, and where a release begins.
#include "cansync/process_data/reference_check.h"

#include <gtest/gtest.h>

#include "process_data_rig.h"

namespace cansync::test {
namespace {

constexpr CarriedValues kDoublewords{0x0F, 0};
constexpr CarriedValues kWordsOfAll{0x0F, 0x0F};

struct NoActuals : ActualSource {
  std::optional<ActualNumber> recent(SlaveNumber, std::uint8_t) const noexcept override {
    return std::nullopt;
  }
};

/// Slave 3's actual value 5 alone has come.
struct OneActual : ActualSource {
  std::optional<ActualNumber> recent(SlaveNumber who, std::uint8_t value) const noexcept override {
    return who == slave(3) && value == 5 ? there : std::nullopt;
  }
  std::optional<ActualNumber> there;
};

std::uint32_t raw(std::int64_t number) {
  return static_cast<std::uint32_t>(number);
}

AllReferenceLimits limits_of(unsigned value, const ReferenceLimits& limits) {
  AllReferenceLimits all;
  all[value] = limits;
  return all;
}

/// Which limit a value 1 of this number is beyond.
std::optional<LimitKind> judged(const ReferenceCheck& check, std::int64_t number, IntervalNumber now = 100,
                                CarriedValues carried = kDoublewords,
                                const ActualSource& actual = NoActuals{}) {
  const auto beyond = check.judge(Channel::one, carried, {0, raw(number)}, now, actual);
  return beyond ? std::optional(beyond->kind) : std::nullopt;
}

TEST(ReferenceCheck, WithoutLimitsEverythingPasses) {
  const ReferenceCheck check{AllReferenceLimits{}};
  EXPECT_EQ(judged(check, INT32_MIN), std::nullopt);
  EXPECT_EQ(judged(check, INT32_MAX), std::nullopt);
}

TEST(ReferenceCheck, MinimumAndMaximumThemselvesPassAndTheNextNumbersDoNot) {
  const ReferenceCheck check{limits_of(1, {.minimum = -500, .maximum = 700})};
  for (const CarriedValues carried : {kDoublewords, kWordsOfAll}) {
    EXPECT_EQ(judged(check, -501, 100, carried), LimitKind::minimum);
    EXPECT_EQ(judged(check, -500, 100, carried), std::nullopt);
    EXPECT_EQ(judged(check, 700, 100, carried), std::nullopt);
    EXPECT_EQ(judged(check, 701, 100, carried), LimitKind::maximum);
  }
}

TEST(ReferenceCheck, ANumberIsReadWithTheWidthOfTheMappingAndItsSign) {
  const ReferenceCheck with_sign{limits_of(1, {.minimum = -1, .maximum = 0x7FFF})};
  EXPECT_EQ(judged(with_sign, 0xFFFF, 100, kWordsOfAll), std::nullopt) << "a word of -1";
  EXPECT_EQ(judged(with_sign, 0xFFFF), LimitKind::maximum) << "a doubleword of 65535";
  const ReferenceCheck without{limits_of(1, {.is_signed = false, .minimum = 0, .maximum = 0xFFFF'FFFE})};
  EXPECT_EQ(judged(without, -1), LimitKind::maximum);
  EXPECT_EQ(judged(without, -2), std::nullopt);
  EXPECT_EQ(judged(without, -1, 100, kWordsOfAll), std::nullopt) << "a word of 65535";
}

TEST(ReferenceCheck, AViolationNamesValueNumberAndLimit) {
  const ReferenceCheck check{limits_of(6, {.minimum = -5, .maximum = 7})};
  const auto beyond = check.judge(Channel::two, {0xF0, 0}, {0, 0, 0, 0, 0, 0, raw(-6)}, 1, NoActuals{});
  ASSERT_TRUE(beyond.has_value());
  EXPECT_EQ(beyond->kind, LimitKind::minimum);
  EXPECT_EQ(beyond->value, 6);
  EXPECT_EQ(beyond->number, -6);
  EXPECT_EQ(beyond->limit, -5);
}

TEST(ReferenceCheck, AValueThatTheTelegramDoesNotCarryIsNotLookedAt) {
  const ReferenceCheck check{limits_of(1, {.maximum = 10})};
  EXPECT_EQ(judged(check, 11, 100, {0x01, 0}), std::nullopt);
}

TEST(ReferenceCheck, AStepIsTheDifferenceToTheValueSentLastInBothDirections) {
  ReferenceCheck check{limits_of(1, {.max_step = 10})};
  EXPECT_EQ(judged(check, 5'000), std::nullopt) << "nothing was sent before";
  check.sent(kDoublewords, {0, 100}, 100);
  for (const std::int64_t passes : {90, 100, 110}) EXPECT_EQ(judged(check, passes, 101), std::nullopt);
  for (const std::int64_t too_far : {89, 111}) EXPECT_EQ(judged(check, too_far, 101), LimitKind::max_step);
  const auto beyond = check.judge(Channel::one, kDoublewords, {0, 111}, 101, NoActuals{});
  EXPECT_EQ(beyond->number, 111);
  EXPECT_EQ(beyond->against, 100);
  EXPECT_EQ(beyond->limit, 10);
}

TEST(ReferenceCheck, AStepOverTheWholeRangeIsCountedWhole) {
  ReferenceCheck check{limits_of(1, {.max_step = 0xFFFF'FFFE})};
  check.sent(kDoublewords, {0, raw(INT32_MIN)}, 100);
  EXPECT_EQ(judged(check, INT32_MAX, 101), LimitKind::max_step) << "4294967295, and no wrap to -1";
  EXPECT_EQ(judged(check, INT32_MAX - 1, 101), std::nullopt);
}

TEST(ReferenceCheck, AGapDoesNotAddToTheStep) {
  ReferenceCheck check{limits_of(1, {.max_step = 10})};
  check.sent(kDoublewords, {0, 100}, 100);
  for (const IntervalNumber later : {101u, 102u, 110u, 111u, 1'000'000u}) {
    EXPECT_EQ(judged(check, 110, later), std::nullopt) << later;
    EXPECT_EQ(judged(check, 111, later), LimitKind::max_step) << later;
  }
  check.forget();
  EXPECT_EQ(judged(check, 5'000, 101), std::nullopt) << "another active operation";
}

TEST(ReferenceCheck, AStepIsCountedInNumbersAlsoFromWordToDoubleword) {
  ReferenceCheck check{limits_of(1, {.max_step = 10})};
  check.sent(kWordsOfAll, {0, 0xFFFF}, 100);
  EXPECT_EQ(judged(check, 9, 101), std::nullopt) << "from -1";
  EXPECT_EQ(judged(check, 10, 101), LimitKind::max_step);
  EXPECT_EQ(judged(check, 0xFFFF, 101), LimitKind::max_step);
}

TEST(ReferenceCheck, AValueThatWasNotCarriedMeanwhileIsStillTheOneSentLast) {
  ReferenceCheck check{limits_of(1, {.max_step = 10})};
  check.sent(kDoublewords, {0, 100}, 100);
  check.sent({0x01, 0}, {0, 900}, 101);
  EXPECT_EQ(judged(check, 900, 102), LimitKind::max_step);
  EXPECT_EQ(judged(check, 105, 102), std::nullopt);
}

constexpr StartWithin kStart{.slave = SlaveNumber{}, .value = 5, .distance = 20.0};

ReferenceLimits start_near_slave_three(std::int64_t max_step = ReferenceLimits::kNone) {
  ReferenceLimits limits;
  limits.max_step = max_step;
  limits.start_within = kStart;
  limits.start_within->slave = slave(3);
  return limits;
}

TEST(ReferenceCheck, AReleaseBeginsNearItsActualValueOrNotAtAll) {
  const ReferenceCheck check{limits_of(1, start_near_slave_three())};
  OneActual actual;
  EXPECT_EQ(judged(check, 0, 100, kDoublewords, actual), LimitKind::start_unknown);
  actual.there = ActualNumber{raw(-1'000), false};
  for (const std::int64_t near : {-1'020, -1'000, -980})
    EXPECT_EQ(judged(check, near, 100, kDoublewords, actual), std::nullopt) << near;
  for (const std::int64_t far : {-1'021, -979, 1'000})
    EXPECT_EQ(judged(check, far, 100, kDoublewords, actual), LimitKind::start_within) << far;
  actual.there = ActualNumber{0xFC18, true};
  EXPECT_EQ(judged(check, -1'020, 100, kDoublewords, actual), std::nullopt) << "-1000 as a word";
}

TEST(ReferenceCheck, TheActualValueIsScaledToTheReferenceValue) {
  ReferenceLimits limits = start_near_slave_three();
  limits.start_within->factor = -0.1;
  limits.start_within->offset = 7.0;
  limits.start_within->distance = 0.3;
  const ReferenceCheck check{limits_of(1, limits)};
  OneActual actual;
  actual.there = ActualNumber{raw(127), false};  // 127 * -0.1 + 7 = -5.7
  EXPECT_EQ(judged(check, -6, 100, kDoublewords, actual), std::nullopt) << "the distance itself";
  EXPECT_EQ(judged(check, -5, 100, kDoublewords, actual), LimitKind::start_within);
}

TEST(ReferenceCheck, WithinAReleaseTheActualValueIsNotLookedAt) {
  ReferenceCheck check{limits_of(1, start_near_slave_three(10))};
  const NoActuals actual;
  check.sent(kDoublewords, {0, 100}, 100);
  EXPECT_EQ(judged(check, 110, 101), std::nullopt);
  EXPECT_EQ(judged(check, 110, 100 + ReferenceCheck::kContinues), std::nullopt);
  EXPECT_EQ(judged(check, 110, 101 + ReferenceCheck::kContinues), LimitKind::start_unknown)
      << "so long without a telegram a release begins";
}

TEST(ReferenceCheck, AfterALongGapTheDriveMayBeElsewhere) {
  ReferenceCheck check{limits_of(1, start_near_slave_three(10))};
  OneActual actual;
  actual.there = ActualNumber{9'000, false};
  check.sent(kDoublewords, {0, 100}, 100);
  EXPECT_EQ(judged(check, 9'000, 101 + ReferenceCheck::kContinues, kDoublewords, actual), std::nullopt);
  EXPECT_EQ(judged(check, 9'000, 100 + ReferenceCheck::kContinues, kDoublewords, actual),
            LimitKind::max_step);
}

TEST(ReferenceCheck, AfterAReleaseWasWithdrawnTheNextOneSatisfiesStepAndActualValue) {
  ReferenceCheck check{limits_of(1, start_near_slave_three(10))};
  OneActual actual;
  actual.there = ActualNumber{85, false};
  check.sent(kDoublewords, {0, 100}, 100);
  check.withdrawn(Channel::one);
  check.sent(kDoublewords, {0, 100}, 101);  // held a little longer
  EXPECT_EQ(judged(check, 106, 102, kDoublewords, actual), LimitKind::start_within);
  EXPECT_EQ(judged(check, 84, 102, kDoublewords, actual), LimitKind::max_step);
  EXPECT_EQ(judged(check, 105, 102, kDoublewords, actual), std::nullopt);
  check.taken(Channel::one);
  EXPECT_EQ(judged(check, 106, 102, kDoublewords, actual), std::nullopt);
}

// --- on the master

ReferenceUpdate update(std::uint32_t value, std::uint32_t intervals = 1, IntervalNumber from = 0) {
  return {.value = {value}, .valid_mask = 1, .from_interval = from, .release_intervals = intervals};
}

MasterSettings limited(const ReferenceLimits& limits) {
  MasterSettings settings = settings_for(2);
  settings.process.reference_limits[0] = limits;
  return settings;
}

/// Value 0 in the reference telegram of the newest interval.
std::optional<std::uint32_t> sent_value(const MasterRig& rig) {
  const auto frames = references(rig);
  if (frames.empty() || frames[0].dlc < 4) return std::nullopt;
  return load_doubleword(frames[0].data.data());
}

TEST(ReferenceLimits, ASampleBeyondALimitIsRefusedWholeAndTheReleaseGoesOn) {
  auto rig = active_line(limited({.maximum = 100}));
  ASSERT_EQ(rig->master.submit({.value = {100, 7}, .valid_mask = 3, .release_intervals = 3}), Refusal::none);
  rig->step();
  ASSERT_EQ(rig->master.submit({.value = {101, 8}, .valid_mask = 3, .release_intervals = 9}), Refusal::none);
  rig->step();
  EXPECT_EQ(references(*rig)[0].data, (can::Frame{.data = {100, 0, 0, 0, 7}}.data)) << "value 1 neither";
  ASSERT_EQ(rig->told.beyond_limits.size(), 1u);
  EXPECT_EQ(rig->told.beyond_limits[0].number, 101);
  EXPECT_EQ(rig->master.release(Channel::one).beyond_limits, 1u);
  EXPECT_EQ(rig->master.release(Channel::one).updates, 1u);
  rig->step();
  EXPECT_EQ(sent_value(*rig), 100u);
  rig->step();
  EXPECT_EQ(sent_value(*rig), std::nullopt) << "3 intervals as the good sample said";
}

TEST(ReferenceLimits, AValueThatKeepsWhatItGotIsLookedAtToo) {
  MasterSettings settings = settings_for(2);
  settings.process.reference_limits[1] = {.minimum = 5};
  auto rig = active_line(settings);
  ASSERT_EQ(rig->master.submit(update(1)), Refusal::none);
  rig->step();
  ASSERT_EQ(rig->told.beyond_limits.size(), 1u) << "value 1 was never given, and would go out as 0";
  EXPECT_EQ(rig->told.beyond_limits[0].value, 1);
}

TEST(ReferenceLimits, AStepIsMeasuredFromTheBusAlsoForValuesOfALaterInterval) {
  auto rig = active_line(limited({.max_step = 10}));
  const IntervalNumber now = rig->next_interval;
  ASSERT_EQ(rig->master.submit(update(100, 1, now)), Refusal::none);
  ASSERT_EQ(rig->master.submit(update(120, 1, now + 2)), Refusal::none);
  ASSERT_EQ(rig->master.submit(update(110, 1, now + 1)), Refusal::none);
  ASSERT_EQ(rig->master.submit(update(111, 1, now + 3)), Refusal::none);
  std::vector<std::optional<std::uint32_t>> bus;
  for (int i = 0; i < 4; ++i) {
    rig->step();
    bus.push_back(sent_value(*rig));
  }
  EXPECT_EQ(bus, (std::vector<std::optional<std::uint32_t>>{100, 110, 120, 111}));
  EXPECT_TRUE(rig->told.beyond_limits.empty());
  ASSERT_EQ(rig->master.submit(update(122)), Refusal::none);
  rig->step();
  EXPECT_EQ(sent_value(*rig), std::nullopt);
  ASSERT_EQ(rig->told.beyond_limits.size(), 1u);
  EXPECT_EQ(rig->told.beyond_limits[0].against, 111);
}

TEST(ReferenceLimits, OfTwoSamplesForOneIntervalTheSecondIsMeasuredFromTheBus) {
  auto rig = active_line(limited({.max_step = 10}));
  ASSERT_EQ(rig->master.submit(update(100)), Refusal::none);
  rig->step();
  ASSERT_EQ(rig->master.submit(update(110)), Refusal::none);
  ASSERT_EQ(rig->master.submit(update(120)), Refusal::none);
  rig->step();
  EXPECT_EQ(sent_value(*rig), 110u) << "120 is two steps from the 100 on the bus";
}

TEST(ReferenceLimits, AWriterThatTakesOverGoesNotRoundTheStep) {
  auto rig = active_line(limited({.max_step = 10}));
  ASSERT_EQ(rig->master.submit(update(100, 5)), Refusal::none);
  rig->step();
  ReferenceUpdate other = update(500, 5);
  other.takes_over = true;
  ASSERT_EQ(rig->master.submit(other), Refusal::none);
  rig->step();
  EXPECT_EQ(sent_value(*rig), std::nullopt);
  EXPECT_EQ(rig->told.beyond_limits.size(), 1u);
}

TEST(ReferenceLimits, AnotherMappingGoesNotRoundTheLimits) {
  auto rig = active_line(limited({.maximum = 40'000, .max_step = 10}));
  ASSERT_EQ(rig->master.submit(update(40'000)), Refusal::none);
  rig->step();
  ProcessMapping words;
  words[0].word[0] = {true, false, 0};
  ASSERT_EQ(rig->master.set_reference_mapping(words), Refusal::none);
  ReferenceUpdate same = update(40'000);
  same.mapping_number = 2;
  ASSERT_EQ(rig->master.submit(same), Refusal::none);
  rig->step();
  EXPECT_TRUE(references(*rig).empty());
  ASSERT_EQ(rig->told.beyond_limits.size(), 1u);
  EXPECT_EQ(rig->told.beyond_limits[0].number, -25'536) << "the same bits as a word";
}

TEST(ReferenceLimits, NewLimitsEndAReleaseThatIsBeyondThem) {
  auto rig = active_line(limited({.maximum = 100}));
  ASSERT_EQ(rig->master.submit(update(100, 50)), Refusal::none);
  rig->step();
  rig->master.set_reference_limits(0, {.maximum = 100});
  rig->step();
  EXPECT_EQ(sent_value(*rig), 100u);
  rig->master.set_reference_limits(0, {.maximum = 99});
  rig->step();
  EXPECT_EQ(sent_value(*rig), std::nullopt);
  EXPECT_EQ(rig->told.beyond_limits.size(), 1u);
  EXPECT_EQ(rig->master.settings().process.reference_limits[0].maximum, 99);
}

TEST(ReferenceLimits, ATelegramThatWasLeftOutIsNotOnTheBus) {
  auto rig = active_line(limited({.max_step = 10}));
  ASSERT_EQ(rig->master.submit(update(100)), Refusal::none);
  rig->step();
  ASSERT_EQ(rig->master.submit(update(110)), Refusal::none);
  rig->master.begin_interval(rig->next_interval++);
  ASSERT_TRUE(rig->master.take(Slot::reference_one).has_value());
  rig->master.left_out(Slot::reference_one);
  ASSERT_EQ(rig->master.submit(update(120)), Refusal::none);
  rig->step();
  EXPECT_EQ(sent_value(*rig), std::nullopt);
}

TEST(ReferenceLimits, AReleaseBeginsNearAnActualValueThatHasComeLately) {
  ReferenceLimits limits;
  limits.start_within = StartWithin{.slave = slave(1), .value = 0, .distance = 5.0};
  MasterSettings settings = limited(limits);
  settings.process.poll_without_reference = true;
  auto rig = active_line(settings);
  bool silent = true;
  rig->answer = [&](const Telegram& telegram) -> std::optional<Telegram> {
    const auto* reference = std::get_if<ReferenceTelegram>(&telegram);
    if (reference == nullptr || reference->polled > 31) return MasterRig::status_only(telegram);
    if (silent) return std::nullopt;
    return ActualTelegram{reference->channel, slave(reference->polled), 4, {1'000, 0, 0, 0}};
  };
  const auto kind_of = [&](std::uint32_t value) -> std::optional<LimitKind> {
    const std::size_t before = rig->told.beyond_limits.size();
    EXPECT_EQ(rig->master.submit(update(value)), Refusal::none);
    rig->step();
    if (rig->told.beyond_limits.size() == before) return std::nullopt;
    return rig->told.beyond_limits.back().kind;
  };
  rig->run(3);
  EXPECT_EQ(kind_of(1'000), LimitKind::start_unknown) << "it has not come at all";
  silent = false;
  rig->run(4);
  EXPECT_EQ(kind_of(1'006), LimitKind::start_within);
  EXPECT_EQ(kind_of(1'005), std::nullopt);
  EXPECT_EQ(kind_of(9'000), std::nullopt) << "within a release";
  silent = true;
  rig->run(40);
  EXPECT_EQ(kind_of(1'000), LimitKind::start_unknown) << "too long ago";
  silent = false;
  rig->run(4);
  EXPECT_EQ(kind_of(1'000), std::nullopt);
  rig->run(11);
  ProcessMapping other = {default_mapping(Channel::one), default_mapping(Channel::two)};
  other[0].word[2] = other[0].word[3] = {};
  ASSERT_EQ(rig->master.set_actual_mapping(slave(1), other), Refusal::none);
  EXPECT_EQ(kind_of(1'000), LimitKind::start_unknown) << "none by this mapping";
}

}  // namespace
}  // namespace cansync::test
