#include "process_data_rig.h"

namespace cansync::test {
namespace {

TEST(ProcessData, NothingReleasedMeansNoTelegramAndNoActualValues) {
  auto rig = active_line(settings_for(2));
  rig->run(10);
  EXPECT_TRUE(references(*rig).empty());
  EXPECT_TRUE(rig->told.actual.empty());
  EXPECT_EQ(rig->master.counters().references_not_released, 20u);
}

TEST(ProcessData, AnUpdateIsReleasedExactlyOnce) {
  MasterSettings settings = settings_for(4);
  settings.process.polling[0] = {Cursor::Kind::fixed, slave(3)};
  auto rig = active_line(settings);
  ASSERT_EQ(rig->master.submit(
                ReferenceUpdate{.channel = Channel::one, .value = {0x11223344, 0x55667788}, .valid_mask = 3}),
            Refusal::none);
  rig->step();
  ASSERT_EQ(references(*rig).size(), 1u);
  // WRC1 that asks slave 3: doubleword values 0 and 1, low word first.
  EXPECT_EQ(references(*rig)[0],
            (can::Frame{.id = 0x103, .dlc = 8, .data = {0x44, 0x33, 0x22, 0x11, 0x88, 0x77, 0x66, 0x55}}));
  ASSERT_EQ(rig->told.actual.size(), 1u);
  EXPECT_EQ(rig->told.actual[0].first, slave(3));
  EXPECT_EQ(rig->told.actual[0].second.value[0], 3u);
  EXPECT_EQ(rig->told.actual[0].second.value[1], 0xFFFFFFFFu);
  rig->run(5);
  EXPECT_TRUE(references(*rig).empty());
  EXPECT_EQ(rig->told.count(MasterEvent::Code::references_released), 1u);
  EXPECT_EQ(rig->told.count(MasterEvent::Code::references_stopped), 1u);
}

TEST(ProcessData, AReleaseThatKeepsStoppingIsToldOnceInAThousandIntervals) {
  auto rig = active_line(settings_for(2));
  for (int i = 0; i < 3000; ++i) {
    if (i % 2 == 0) {
      ASSERT_EQ(rig->master.submit(ReferenceUpdate{.valid_mask = 1}), Refusal::none);
    }
    rig->step();
  }
  EXPECT_EQ(rig->told.count(MasterEvent::Code::references_stopped), 3u);
  rig->run(1000);
  EXPECT_EQ(rig->told.count(MasterEvent::Code::references_stopped), 4u) << "the last stop is told in the end";
  EXPECT_EQ(rig->told.count(MasterEvent::Code::references_released), 4u);
}

TEST(ProcessData, ReleaseForSeveralIntervalsEndsByItself) {
  auto rig = active_line(settings_for(2));
  ASSERT_EQ(rig->master.submit(ReferenceUpdate{
                .channel = Channel::two, .value = {1, 2, 3, 4}, .valid_mask = 15, .release_intervals = 7}),
            Refusal::none);
  unsigned sent = 0;
  for (int i = 0; i < 20; ++i) {
    rig->step();
    sent += static_cast<unsigned>(references(*rig).size());
  }
  EXPECT_EQ(sent, 7u);
}

TEST(ProcessData, StopReleaseTakesEffectInTheNextInterval) {
  auto rig = active_line(settings_for(2));
  ASSERT_EQ(rig->master.submit(ReferenceUpdate{.valid_mask = 1, .release_intervals = 100}), Refusal::none);
  rig->run(3);
  EXPECT_EQ(references(*rig).size(), 1u);
  rig->master.stop_release(Channel::one);
  rig->step();
  EXPECT_TRUE(references(*rig).empty());
}

TEST(ProcessData, ValuesForALaterIntervalWaitForIt) {
  auto rig = active_line(settings_for(2));
  const IntervalNumber now = rig->next_interval;
  rig->step();
  ASSERT_EQ(rig->master.submit(ReferenceUpdate{.value = {5}, .valid_mask = 1, .from_interval = now + 4}),
            Refusal::none);
  for (IntervalNumber n = now + 1; n < now + 8; ++n) {
    rig->step();
    EXPECT_EQ(references(*rig).size(), n == now + 4 ? 1u : 0u) << n - now;
  }
  EXPECT_EQ(rig->master.submit(ReferenceUpdate{.valid_mask = 1, .from_interval = now + 3}),
            Refusal::interval_passed);
  EXPECT_EQ(rig->master.submit(ReferenceUpdate{.valid_mask = 1, .from_interval = now + 5000}),
            Refusal::interval_passed);
}

TEST(ProcessData, ValuesNotValidKeepTheirLastValue) {
  auto rig = active_line(settings_for(2));
  ASSERT_EQ(rig->master.submit(ReferenceUpdate{.value = {0x1111, 0x2222}, .valid_mask = 3}), Refusal::none);
  rig->step();
  ASSERT_EQ(rig->master.submit(ReferenceUpdate{.value = {0x3333, 0x4444}, .valid_mask = 2}), Refusal::none);
  rig->step();
  EXPECT_EQ(references(*rig)[0].data, (std::array<std::uint8_t, 8>{0x11, 0x11, 0, 0, 0x44, 0x44, 0, 0}));
}

TEST(ProcessData, BadUpdatesAreRefused) {
  auto rig = active_line(settings_for(2));
  EXPECT_EQ(rig->master.submit(ReferenceUpdate{.valid_mask = 0}), Refusal::nothing_valid);
  EXPECT_EQ(rig->master.submit(ReferenceUpdate{.valid_mask = 16}), Refusal::nothing_valid);
  EXPECT_EQ(rig->master.submit(ReferenceUpdate{.valid_mask = 1, .release_intervals = 0}),
            Refusal::release_too_long);
  EXPECT_EQ(rig->master.submit(ReferenceUpdate{.valid_mask = 1, .release_intervals = 1001}),
            Refusal::release_too_long);
  for (int i = 0; i < 16; ++i) ASSERT_EQ(rig->master.submit(ReferenceUpdate{.valid_mask = 1}), Refusal::none);
  EXPECT_EQ(rig->master.submit(ReferenceUpdate{.valid_mask = 1}), Refusal::queue_full);
  rig->step();
  EXPECT_EQ(rig->master.submit(ReferenceUpdate{.valid_mask = 1}), Refusal::none) << "closer to its interval";
}

TEST(ProcessData, AutomaticPollingRisesOneSlavePerIntervalAndBothChannelsMayAskOthers) {
  MasterSettings settings = settings_for(5);
  settings.process.polling[1] = {Cursor::Kind::fixed, slave(2)};
  auto rig = active_line(settings);
  ASSERT_EQ(rig->master.submit(ReferenceUpdate{.valid_mask = 1, .release_intervals = 100}), Refusal::none);
  ASSERT_EQ(
      rig->master.submit(ReferenceUpdate{.channel = Channel::two, .valid_mask = 1, .release_intervals = 100}),
      Refusal::none);
  rig->step();
  const std::uint32_t first = references(*rig)[0].id - 0x100;
  for (unsigned i = 1; i < 12; ++i) {
    rig->step();
    EXPECT_EQ(references(*rig)[0].id, 0x100 + (first + i) % 5);
    EXPECT_EQ(references(*rig)[1].id, 0x182u);
  }
}

// M 3.1.1.1: 32 slaves need 16 intervals when two of them report in each.
TEST(ProcessData, CursorsSetApartAskEverySlaveOnceInHalfTheIntervals) {
  for (const unsigned slaves : {1u, 2u, 5u, 32u}) {
    MasterSettings settings = settings_for(slaves);
    settings.process.polling_apart = true;
    auto rig = active_line(settings);
    for (unsigned round = 0; round < 4; ++round) {
      SlaveMask asked;
      SlaveMask first;
      SlaveMask second;
      for (unsigned i = 0; i < slaves; ++i) {
        for (const Channel channel : {Channel::one, Channel::two})
          ASSERT_EQ(rig->master.submit(ReferenceUpdate{.channel = channel, .valid_mask = 0x0F}),
                    Refusal::none);
        rig->step();
        const auto frames = references(*rig);
        ASSERT_EQ(frames.size(), 2u);
        const SlaveNumber one = slave(frames[0].id - 0x100);
        const SlaveNumber two = slave(frames[1].id - 0x180);
        EXPECT_EQ(one.value() == two.value(), slaves == 1);
        first.set(one);
        second.set(two);
        if (i < (slaves + 1) / 2) {
          asked.set(one);
          asked.set(two);
        }
      }
      // The first half of a round may begin anywhere in it: every window of that length has every slave.
      EXPECT_EQ(asked, settings.configured()) << slaves << " slaves, round " << round;
      EXPECT_EQ(first, settings.configured());
      EXPECT_EQ(second, settings.configured());
    }
    // A new maximum keeps them apart.
    if (slaves < 32) continue;
    rig->master.set_maximum_slave(slave(3));
    rig->run(1);
    SlaveMask asked;
    for (unsigned i = 0; i < 2; ++i) {
      for (const Channel channel : {Channel::one, Channel::two})
        ASSERT_EQ(rig->master.submit(ReferenceUpdate{.channel = channel, .valid_mask = 0x0F}), Refusal::none);
      rig->step();
      const auto frames = references(*rig);
      ASSERT_EQ(frames.size(), 2u);
      asked.set(slave(frames[0].id - 0x100));
      asked.set(slave(frames[1].id - 0x180));
    }
    EXPECT_EQ(asked.bits, 0xFu);
  }
}

TEST(ProcessData, PollingNobodyUsesTheReservedNumber) {
  MasterSettings settings = settings_for(2);
  settings.process.polling[0] = {Cursor::Kind::nobody, {}};
  auto rig = active_line(settings);
  ASSERT_EQ(rig->master.submit(ReferenceUpdate{.valid_mask = 1}), Refusal::none);
  rig->step();
  EXPECT_EQ(references(*rig)[0].id, 0x17Fu);
}

TEST(ProcessData, ATelegramAsLongAsItsMapping) {
  MasterSettings settings = settings_for(2);
  settings.process.full_length = false;
  settings.process.reference_mapping[0] = TelegramMapping{{{{true, false, 3}, {}, {}, {}}}};
  auto rig = active_line(settings);
  ASSERT_EQ(rig->master.submit(ReferenceUpdate{.value = {0, 0, 0, 0x1234}, .valid_mask = 8}), Refusal::none);
  rig->step();
  EXPECT_EQ(references(*rig)[0].dlc, 2);
  EXPECT_EQ(references(*rig)[0].data, (std::array<std::uint8_t, 8>{0x34, 0x12}));
}

TEST(ProcessData, PollingWithoutReferenceSendsNoValues) {
  MasterSettings settings = settings_for(2);
  settings.process.poll_without_reference = true;
  auto rig = active_line(settings);
  rig->run(4);
  ASSERT_EQ(references(*rig).size(), 2u);
  EXPECT_EQ(references(*rig)[0].dlc, 0);
  EXPECT_EQ(rig->told.actual.size(), 8u);
}

TEST(ProcessData, OnlyAskedActualValuesAreTaken) {
  MasterSettings settings = settings_for(4);
  settings.process.polling[0] = {Cursor::Kind::fixed, slave(1)};
  settings.process.polling[1] = {Cursor::Kind::nobody, {}};
  auto rig = active_line(settings);
  rig->answer = [](const Telegram& telegram) -> std::optional<Telegram> {
    if (!std::holds_alternative<ReferenceTelegram>(telegram)) return std::nullopt;
    return ActualTelegram{Channel::one, slave(2), 4, {1, 2, 3, 4}};
  };
  ASSERT_EQ(rig->master.submit(ReferenceUpdate{.valid_mask = 1}), Refusal::none);
  rig->run(2);
  EXPECT_TRUE(rig->told.actual.empty());
  EXPECT_EQ(rig->master.counters().unexpected, 1u);
  EXPECT_EQ(rig->master.slave(slave(1)).missed_actual, 1u);
}

TEST(ProcessData, AnActualValueTelegramWithoutAllMappedWordsIsNotTaken) {
  for (unsigned words = 0; words <= 4; ++words) {
    MasterSettings settings = settings_for(4);
    settings.process.polling[0] = {Cursor::Kind::fixed, slave(1)};
    settings.process.polling[1] = {Cursor::Kind::nobody, {}};
    settings.slaves[1].actual_mapping[0].word[3] = {};  // three words are mapped
    auto rig = active_line(settings);
    rig->answer = [words](const Telegram& telegram) -> std::optional<Telegram> {
      if (!std::holds_alternative<ReferenceTelegram>(telegram)) return std::nullopt;
      return ActualTelegram{Channel::one, slave(1), static_cast<std::uint8_t>(words), {1, 2, 3, 4}};
    };
    ASSERT_EQ(rig->master.submit(ReferenceUpdate{.valid_mask = 1}), Refusal::none);
    rig->run(2);
    const unsigned taken = words >= 3 ? 1 : 0;
    EXPECT_EQ(rig->told.actual.size(), taken) << words;
    EXPECT_EQ(rig->master.counters().unexpected, 1 - taken) << words;
    EXPECT_EQ(rig->master.slave(slave(1)).missed_actual, 1 - taken) << words;
    EXPECT_EQ(rig->master.actual(slave(1)).value[1], taken * 3) << words;
  }
}

TEST(ProcessData, ADuplicateOfAnActualValueTelegramIsNotTakenTwice) {
  MasterSettings settings = settings_for(1);
  auto rig = active_line(settings);
  ASSERT_EQ(rig->master.submit(ReferenceUpdate{.valid_mask = 1}), Refusal::none);
  rig->step();
  rig->master.receive(encode(ActualTelegram{Channel::one, slave(0), 4, {9, 9, 9, 9}}),
                      std::chrono::microseconds(600));
  EXPECT_EQ(rig->told.actual.size(), 1u);
  EXPECT_EQ(rig->master.actual(slave(0)).value[0], 0u);
}

TEST(ProcessData, ActualValuesThatComeBeforeTheirQuestionWasOnTheBusAreNotTaken) {
  MasterSettings settings = settings_for(2);
  settings.process.polling[0] = {Cursor::Kind::fixed, slave(1)};
  auto rig = active_line(settings);
  ASSERT_EQ(rig->master.submit(ReferenceUpdate{.valid_mask = 1}), Refusal::none);
  Master& master = rig->master;
  master.begin_interval(rig->next_interval++);
  const auto question = master.take(Slot::reference_one);
  ASSERT_TRUE(question);
  master.sent(Slot::reference_one);
  // Held up on the bus since the last interval, with the values of that one.
  const can::Frame late = encode(ActualTelegram{Channel::one, slave(1), 4, {1, 0, 0, 0}});
  master.receive(late, std::chrono::microseconds(310));
  EXPECT_TRUE(rig->told.actual.empty());
  EXPECT_EQ(master.counters().unexpected, 1u);
  // So was the echo of the question of the last interval.
  can::Frame before = *question;
  before.data[0] ^= 1;
  master.transmitted(before, std::chrono::microseconds(320));
  // And one that looks the same, but was over before this one was due.
  master.transmitted(*question, std::chrono::microseconds(200));
  master.receive(late, std::chrono::microseconds(330));
  EXPECT_TRUE(rig->told.actual.empty());
  master.transmitted(*question, std::chrono::microseconds(420));
  master.receive(encode(ActualTelegram{Channel::one, slave(1), 4, {2, 0, 0, 0}}),
                 std::chrono::microseconds(550));
  ASSERT_EQ(rig->told.actual.size(), 1u);
  EXPECT_EQ(rig->told.actual[0].second.value[0], 2u);
}

TEST(ProcessData, MappingsChangeWhileRunning) {
  auto rig = active_line(settings_for(1));
  ProcessMapping mapping;
  mapping[0].word[0] = {true, true, 2};
  mapping[1].word[3] = {true, false, 7};
  EXPECT_EQ(rig->master.set_reference_mapping(mapping), Refusal::none);
  EXPECT_EQ(rig->master.set_actual_mapping(slave(0), mapping), Refusal::none);
  EXPECT_EQ(rig->master.mapping_number(), 2u);
  ASSERT_EQ(
      rig->master.submit(ReferenceUpdate{.value = {0, 0, 0xAABBCCDD}, .valid_mask = 4, .mapping_number = 2}),
      Refusal::none);
  rig->answer = [](const Telegram&) { return ActualTelegram{Channel::one, slave(0), 4, {0x7788, 0, 0, 0}}; };
  rig->step();
  EXPECT_EQ(references(*rig)[0].data, (std::array<std::uint8_t, 8>{0xBB, 0xAA}));
  EXPECT_EQ(rig->master.actual(slave(0)).value[2], 0x77880000u);
  mapping[0].word[1] = {true, false, 4};  // a value of the other telegram
  EXPECT_EQ(rig->master.set_reference_mapping(mapping), Refusal::mapping);
  EXPECT_EQ(rig->master.set_actual_mapping(slave(0), mapping), Refusal::mapping);
  EXPECT_EQ(rig->master.set_actual_mapping(slave(9), {}), Refusal::slave_not_configured);
}

/// Reference telegrams that go out within so many intervals: the first byte of each.
std::vector<unsigned> on_bus(MasterRig& rig, unsigned intervals) {
  std::vector<unsigned> bytes;
  for (unsigned i = 0; i < intervals; ++i) {
    rig.step();
    for (const can::Frame& frame : references(rig)) bytes.push_back(frame.data[0]);
  }
  return bytes;
}
using Bytes = std::vector<unsigned>;

// What was given for one mapping means something else under another: none of it goes out.
TEST(ProcessData, NoValueIsReleasedUnderAnotherMappingThanItWasGivenFor) {
  auto rig = active_line(settings_for(1));
  ReferenceUpdate update{.value = {0x11, 0x22}, .valid_mask = 3, .release_intervals = 100};
  ASSERT_EQ(rig->master.submit(update), Refusal::none);
  update.from_interval = rig->next_interval + 5;
  ASSERT_EQ(rig->master.submit(update), Refusal::none);
  EXPECT_EQ(on_bus(*rig, 2), (Bytes{0x11, 0x11}));
  ProcessMapping mapping = rig->master.settings().process.reference_mapping;
  ASSERT_EQ(rig->master.set_reference_mapping(mapping), Refusal::none) << "the same: nothing changes";
  EXPECT_EQ(on_bus(*rig, 1), (Bytes{0x11}));
  EXPECT_EQ(rig->master.mapping_number(), 1u);

  mapping[0].word[0] = {true, false, 1};
  ASSERT_EQ(rig->master.set_reference_mapping(mapping), Refusal::none);
  EXPECT_EQ(rig->master.mapping_number(), 2u);
  EXPECT_EQ(on_bus(*rig, 20), Bytes{});
  const ReleaseStatus& release = rig->master.release(Channel::one);
  EXPECT_EQ(release.state, ReleaseStatus::State::stopped);
  EXPECT_EQ(release.cause, ReleaseStatus::Cause::mapping_changed);
  EXPECT_EQ(release.mapping_changed, 1u);
  EXPECT_EQ(rig->master.release(Channel::two).mapping_changed, 0u) << "nothing was given there";

  update.from_interval = 0;
  EXPECT_EQ(rig->master.submit(update), Refusal::mapping_changed);
  EXPECT_EQ(on_bus(*rig, 2), Bytes{});
  update.mapping_number = 2;
  ASSERT_EQ(rig->master.submit(update), Refusal::none);
  EXPECT_EQ(on_bus(*rig, 1), (Bytes{0x22}));
}

// The giver that takes over counts from the moment it is seen, whatever its first values are refused for.
TEST(ProcessData, NothingOfTheGiverBeforeGoesOutAfterATakeOverThatIsRefused) {
  struct Case {
    const char* name;
    ReferenceUpdate first;
    Refusal refusal;
  };
  const Case cases[] = {
      {"interval passed", {.value = {0x22}, .valid_mask = 1, .from_interval = 1}, Refusal::interval_passed},
      {"nothing valid", {.value = {0x22}, .valid_mask = 0}, Refusal::nothing_valid},
      {"too long", {.value = {0x22}, .valid_mask = 1, .release_intervals = 9999}, Refusal::release_too_long},
      {"other mapping", {.value = {0x22}, .valid_mask = 1, .mapping_number = 7}, Refusal::mapping_changed},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    auto rig = active_line(settings_for(1));
    rig->run(3);
    ReferenceUpdate weak{.value = {0x11}, .valid_mask = 1, .release_intervals = 50};
    ASSERT_EQ(rig->master.submit(weak), Refusal::none);
    EXPECT_EQ(on_bus(*rig, 2), (Bytes{0x11, 0x11}));
    weak.release_intervals = 1;
    for (unsigned i = 0; i < 16; ++i) {  // as many as may wait
      weak.from_interval = rig->next_interval + 4 + i;
      ASSERT_EQ(rig->master.submit(weak), Refusal::none);
    }

    ReferenceUpdate strong = c.first;
    strong.takes_over = true;
    EXPECT_EQ(rig->master.submit(strong), c.refusal);
    EXPECT_EQ(on_bus(*rig, 3), Bytes{}) << "of the weaker after the take-over";
    // The stronger one's next values find room and go out.
    ASSERT_EQ(rig->master.submit(ReferenceUpdate{.value = {0x33}, .valid_mask = 1}), Refusal::none);
    EXPECT_EQ(on_bus(*rig, 60), (Bytes{0x33}));
  }
}

TEST(ProcessData, ATakeOverForALaterIntervalEndsTheReleaseAtOnce) {
  auto rig = active_line(settings_for(1));
  ASSERT_EQ(rig->master.submit(ReferenceUpdate{.value = {0x11}, .valid_mask = 1, .release_intervals = 50}),
            Refusal::none);
  EXPECT_EQ(on_bus(*rig, 2), (Bytes{0x11, 0x11}));
  ASSERT_EQ(
      rig->master.submit(ReferenceUpdate{
          .value = {0x22}, .valid_mask = 1, .from_interval = rig->next_interval + 5, .takes_over = true}),
      Refusal::none);
  EXPECT_EQ(on_bus(*rig, 5), Bytes{});
  EXPECT_EQ(on_bus(*rig, 5), (Bytes{0x22}));
}

TEST(ProcessData, AReferenceTelegramLeftOutIsNotSentLater) {
  auto rig = active_line(settings_for(1));
  ASSERT_EQ(rig->master.submit(ReferenceUpdate{.value = {5}, .valid_mask = 1}), Refusal::none);
  rig->master.begin_interval(rig->next_interval++);
  ASSERT_TRUE(rig->master.take(Slot::reference_one).has_value());
  rig->master.left_out(Slot::reference_one);
  rig->run(3);
  EXPECT_TRUE(references(*rig).empty());
}

}  // namespace
}  // namespace cansync::test
