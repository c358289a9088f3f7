// When a slave answers, and what it knows of its answers: rows S16, S17, S19, S20 and S28 of
// docs/cansync-slave.md.
#include <gtest/gtest.h>

#include <chrono>
#include <optional>

#include "cansync/slave/answer_slot.h"
#include "cansync/slave/slave.h"
#include "slave_rig.h"

namespace cansync::test {
namespace {

using std::chrono::microseconds;

// --- the windows, with the numbers of the table of M 3.1.1.1

struct LatestStarts {
  BitRate rate;
  int interval, rc, rdc1, rdc2, cc, rspto;  // microseconds
};
constexpr LatestStarts kManual[] = {{BitRate::mbit1, 1000, 210, 520, 820, 950, 300},
                                    {BitRate::kbit500, 2000, 460, 1060, 1630, 1890, 600},
                                    {BitRate::kbit250, 4000, 900, 2100, 3290, 3810, 1100},
                                    {BitRate::kbit125, 8000, 1920, 4310, 6640, 7680, 2100}};

StartWindow window(AnswerSlot slot, bool process_data, BitRate rate, int asked_until) {
  return start_window(slot, process_data, slot_times(rate), microseconds(asked_until));
}
StartWindow from_to(int earliest, int latest) {
  return {microseconds(earliest), microseconds(latest)};
}

TEST(AnswerSlot, S16ActualValuesStartByTheirSlot) {
  for (const LatestStarts& row : kManual) {
    EXPECT_EQ(window(AnswerSlot::actual_one, true, row.rate, 400), from_to(400, row.rdc1));
    EXPECT_EQ(window(AnswerSlot::actual_two, true, row.rate, 700), from_to(700, row.rdc2));
    EXPECT_EQ(window(AnswerSlot::actual_one, true, row.rate, row.interval + 300),
              from_to(row.interval + 300, row.rdc1))
        << "with its edge away it cannot be timed";
    EXPECT_EQ(window(AnswerSlot::actual_two, true, row.rate, -5), from_to(-5, row.rdc2 - row.interval))
        << "a telegram of the interval before";
  }
}

TEST(AnswerSlot, S28ResponsesStartByTrcOfTheNextInterval) {
  for (const LatestStarts& row : kManual) {
    const auto response = [&](bool process_data, int asked_until) {
      return window(AnswerSlot::response, process_data, row.rate, asked_until);
    };
    EXPECT_EQ(response(true, row.cc + 20), from_to(row.interval, row.interval + row.rc));
    EXPECT_EQ(response(true, 30), from_to(30, row.rc)) << "the command went on into this interval";
    EXPECT_EQ(response(true, row.rc), from_to(row.rc, row.rc));
    EXPECT_EQ(response(true, row.rc + 1), from_to(row.interval, row.interval + row.rc));
    EXPECT_EQ(response(false, row.rc + 100), from_to(row.rc + 100, row.rc + 100 + row.rspto))
        << "set up, within tRSPTO";
    EXPECT_EQ(response(false, row.cc - row.rspto), from_to(row.cc - row.rspto, row.cc));
    for (const int late : {row.cc - row.rspto + 1, row.cc - 200, row.cc + 1})
      EXPECT_EQ(response(false, late), from_to(row.interval, row.interval + row.rc)) << "in operation";
    EXPECT_EQ(response(true, row.interval + row.cc), from_to(2 * row.interval, 2 * row.interval + row.rc));
    EXPECT_EQ(response(true, -10), from_to(0, row.rc));
  }
}

// --- releases

class AnswerTest : public SlaveTest {
 protected:
  AnswerTest() : SlaveTest(monitoring()) {}
  static SlaveSideSettings monitoring() {
    SlaveSideSettings settings;
    for (const unsigned other : {9u, 31u})
      settings.monitored[other] =
          ProcessMapping{default_mapping(Channel::one), default_mapping(Channel::two)};
    return settings;
  }
  std::optional<SlaveAnswer> ask(std::uint32_t id, int until = 400) {
    return slave_.receive(frame(id, {1, 0, 2, 0, 3, 0, 4, 0}), microseconds(until));
  }
  const ActualCounters& one() const { return slave_.counters(Channel::one); }
};

TEST_F(AnswerTest, S16ReleaseIsAcknowledgedStepByStep) {
  activate();
  slave_.on_sync();
  EXPECT_EQ(slave_.release(Channel::one), ActualRelease::none);
  slave_.release_actual(Channel::one, {7});
  EXPECT_EQ(slave_.release(Channel::one), ActualRelease::released);
  const auto answer = ask(0x100 + kNumber);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->slot, AnswerSlot::actual_one);
  EXPECT_EQ(slave_.release(Channel::one), ActualRelease::built);
  EXPECT_TRUE(slave_.may_start(*answer, microseconds(430)));
  slave_.sent(frame(0x300 + 9, {}));
  EXPECT_EQ(slave_.release(Channel::one), ActualRelease::built) << "somebody else's telegram";
  slave_.sent(answer->frame);
  EXPECT_EQ(slave_.release(Channel::one), ActualRelease::sent);
  EXPECT_EQ(slave_.release(Channel::two), ActualRelease::none);
  slave_.on_sync();
  EXPECT_EQ(slave_.release(Channel::one), ActualRelease::none);
  EXPECT_EQ(one().asked, 1u);
  EXPECT_EQ(one().released, 1u);
  EXPECT_EQ(one().sent, 1u);
  EXPECT_EQ(one().late + one().lost + one().not_asked + one().not_released, 0u);
}

TEST_F(AnswerTest, S16AtTheLatestStartItGoesOneMicrosecondLaterItIsLeftOut) {
  activate();
  for (const bool late : {false, true}) {
    slave_.on_sync();
    slave_.release_actual(Channel::one, {});
    const auto answer = ask(0x100 + kNumber);
    ASSERT_TRUE(answer);
    EXPECT_EQ(slave_.may_start(*answer, microseconds(late ? 521 : 520)), !late);
    if (late) {
      EXPECT_EQ(slave_.release(Channel::one), ActualRelease::late);
    }
    EXPECT_FALSE(ask(0x100 + kNumber)) << "the release is used up either way";
  }
  EXPECT_EQ(one().late, 1u);
  EXPECT_EQ(one().not_released, 2u);
}

TEST_F(AnswerTest, S16AskedAndNotReleasedReleasedAndNotAsked) {
  activate();
  slave_.on_sync();
  EXPECT_FALSE(ask(0x100 + kNumber));
  EXPECT_EQ(one().not_released, 1u);
  slave_.release_actual(Channel::one, {});
  EXPECT_FALSE(ask(0x100 + 4)) << "another slave is asked";
  EXPECT_FALSE(ask(0x100 + 127)) << "nobody is asked";
  slave_.on_sync();
  EXPECT_EQ(one().not_asked, 1u);
  EXPECT_EQ(one().asked, 1u);
  EXPECT_FALSE(ask(0x100 + kNumber)) << "a release ends with its interval";
}

TEST_F(AnswerTest, S16AnAnswerThatNeverWasOnTheBusIsCounted) {
  activate();
  slave_.on_sync();
  slave_.release_actual(Channel::one, {});
  const auto answer = ask(0x100 + kNumber);
  ASSERT_TRUE(answer);
  ASSERT_TRUE(slave_.may_start(*answer, microseconds(430)));
  slave_.on_sync();
  EXPECT_EQ(one().lost, 0u) << "the echo may be told of after the edge";
  slave_.on_sync();
  EXPECT_EQ(one().lost, 1u);
  slave_.sent(answer->frame);
  EXPECT_EQ(one().sent, 0u);
}

TEST_F(AnswerTest, S16AnEchoAfterTheEdgeCountsForItsInterval) {
  activate();
  slave_.on_sync();
  slave_.release_actual(Channel::one, {});
  const auto answer = ask(0x100 + kNumber);
  ASSERT_TRUE(answer);
  ASSERT_TRUE(slave_.may_start(*answer, microseconds(430)));
  slave_.on_sync();
  slave_.release_actual(Channel::one, {});
  slave_.sent(answer->frame);
  EXPECT_EQ(one().sent, 1u);
  EXPECT_EQ(slave_.release(Channel::one), ActualRelease::released) << "that of the new interval";
}

TEST_F(AnswerTest, S16ALateAnswerOfTheIntervalBeforeLeavesTheReleaseOfThisOne) {
  activate();
  slave_.on_sync();
  slave_.release_actual(Channel::one, {});
  const auto answer = ask(0x100 + kNumber);
  ASSERT_TRUE(answer);
  slave_.on_sync();
  slave_.release_actual(Channel::one, {});
  EXPECT_FALSE(slave_.may_start(*answer, microseconds(1010))) << "of the interval before";
  EXPECT_EQ(one().late, 1u);
  EXPECT_EQ(slave_.release(Channel::one), ActualRelease::released);
  EXPECT_TRUE(ask(0x100 + kNumber));
}

TEST_F(AnswerTest, S16TheFirstAnswerKeepsTheSlotsOfALineThatRuns) {
  slave_.on_sync();
  EXPECT_FALSE(ask(0x100 + kNumber, 340)) << "it takes no part yet";
  set_up();
  ParameterCommand read;
  read.slave = *SlaveNumber::from(kNumber);
  read.number = *ParameterNumber::from(301);
  const auto answer = slave_.receive(encode(read), microseconds(576));
  ASSERT_TRUE(answer);
  const SlotTimes& times = slot_times(SlaveSideSettings{}.bit_rate);
  EXPECT_EQ(answer->window, (StartWindow{times.interval, times.interval + times.response}))
      << "not beside the actual values of another";
}

// --- what other slaves say

TEST_F(AnswerTest, S17MonitoredValuesCarryTheirIntervalAndTheChannelItsSlave) {
  activate();
  slave_.on_sync(5);
  EXPECT_EQ(slave_.heard(Channel::one), std::nullopt);
  ask(0x300 + 9);
  ask(0x380 + 31);
  ask(0x300 + 8);
  EXPECT_EQ(slave_.heard(Channel::one), SlaveNumber::from(9)) << "slave 8 is not monitored";
  EXPECT_EQ(slave_.heard(Channel::two), SlaveNumber::from(31));
  EXPECT_EQ(slave_.monitored_interval(*SlaveNumber::from(9), Channel::one), 5u);
  slave_.on_sync(2);
  EXPECT_EQ(slave_.heard(Channel::one), std::nullopt);
  EXPECT_EQ(slave_.interval(), 7u);
  ask(0x380 + 9);
  EXPECT_EQ(slave_.monitored_interval(*SlaveNumber::from(9), Channel::one), 5u);
  EXPECT_EQ(slave_.monitored_interval(*SlaveNumber::from(9), Channel::two), 7u);
}

// --- actions

TEST_F(AnswerTest, S19SyncModeIsKeptWhateverItSays) {
  set_up();
  EXPECT_EQ(slave_.sync_mode(), std::nullopt);
  send(frame(0x010, {0x20, 0, 0, 0, 2, 1, 0, 0}));
  EXPECT_EQ(slave_.sync_mode(), 1);
  send(frame(0x010, {0x20, 0, 0, 0, 2, 0x84, 0, 0}));
  EXPECT_EQ(slave_.sync_mode(), 0x84);
  EXPECT_TRUE(slave_.sync_activated()) << "other data is not acted on";
  send(frame(0x010, {0x40, 0, 0, 0, 2, 3, 0, 0}));
  EXPECT_EQ(slave_.sync_mode(), 0x84) << "another slave's";
  slave_.control(ControlCommand::cold_restart);
  EXPECT_EQ(slave_.sync_mode(), std::nullopt);
}

// --- the answer was on the bus

TEST_F(AnswerTest, S20TheApplicationLearnsThatItsAnswerWasOnTheBus) {
  set_up();
  const can::Frame read = command({0x71, 0x2D, 0, 0});
  application_.parameter.busy = true;
  auto answer = slave_.receive(read, microseconds(400));
  ASSERT_TRUE(answer && slave_.may_start(*answer, microseconds(420)));
  slave_.sent(answer->frame);
  EXPECT_EQ(application_.take(), "read 301.7/0") << "busy is no answer";
  application_.parameter = {false, ParameterError::not_present, false, 0};
  answer = slave_.receive(read, microseconds(400));
  ASSERT_TRUE(answer && slave_.may_start(*answer, microseconds(420)));
  EXPECT_EQ(application_.take(), "read 301.7/0");
  slave_.sent(answer->frame);
  slave_.sent(answer->frame);
  EXPECT_EQ(application_.take(), "parameter answered") << "an error, too, and once";
  EXPECT_EQ(slave_.response_counters().asked, 2u);
  EXPECT_EQ(slave_.response_counters().busy, 1u);
  EXPECT_EQ(slave_.response_counters().sent, 2u);
}

TEST_F(AnswerTest, S20AWriteWhoseAnswerWasNeverOnTheBusIsNotWrittenAgain) {
  set_up();
  const can::Frame write = command({0x71, 0x90, 0x22, 0x11, 0, 0});
  const auto first = slave_.receive(write, microseconds(400));
  ASSERT_TRUE(first);
  EXPECT_FALSE(slave_.may_start(*first, microseconds(951))) << "too late: the master asks again";
  EXPECT_EQ(application_.take(), "write 400/0 w 4386");
  application_.parameter.error = ParameterError::above_maximum;
  const auto again = slave_.receive(write, microseconds(400));
  ASSERT_TRUE(again && slave_.may_start(*again, microseconds(420)));
  EXPECT_EQ(again->frame, first->frame) << "the same answer";
  EXPECT_EQ(application_.take(), "");
  slave_.sent(again->frame);
  EXPECT_EQ(application_.take(), "parameter answered");
  EXPECT_NE(slave_.receive(write, microseconds(400))->frame, first->frame) << "a write of its own";
  EXPECT_EQ(application_.take(), "write 400/0 w 4386");
  send(command({0x71, 0x90, 0x23, 0x11, 0, 0}));
  application_.take();
  send(write);
  EXPECT_EQ(application_.take(), "write 400/0 w 4386") << "another one was between";
}

TEST_F(AnswerTest, S23TheApplicationLearnsThatTheEndOfABlockWasAnswered) {
  set_up();
  auto answer = slave_.receive(command({0x90, 12, 0, 1, 0, 0, 0, 0}), microseconds(400));
  ASSERT_TRUE(answer && slave_.may_start(*answer, microseconds(420)));
  slave_.sent(answer->frame);
  EXPECT_EQ(application_.take(), "begin 256, transfer answered");
}

TEST_F(AnswerTest, S28AResponseAfterItsSlotIsLeftOutAndCounted) {
  activate();
  slave_.on_sync();
  ask(0x17F);
  const auto answer = slave_.receive(command({0x71, 0x2D, 0, 0}), microseconds(990));
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->window, from_to(1000, 1210));
  EXPECT_FALSE(slave_.may_start(*answer, microseconds(1211)));
  slave_.sent(answer->frame);
  EXPECT_EQ(application_.take(), "read 301.7/0") << "nothing was sent";
  EXPECT_EQ(slave_.response_counters().late, 1u);
  EXPECT_TRUE(slave_.may_start(*answer, microseconds(1210)));
}

TEST_F(AnswerTest, S28WithoutProcessDataForAnIntervalTheLineIsSetUp) {
  activate();
  const auto latest = [this] {
    return slave_.receive(command({0x71, 0x2D, 0, 0}), microseconds(400))->window.latest;
  };
  EXPECT_EQ(latest(), microseconds(400 + 300));
  ask(0x17F);
  EXPECT_EQ(latest(), microseconds(1210));
  slave_.on_sync();
  EXPECT_EQ(latest(), microseconds(1210)) << "WRC1 of this interval is still to come";
  slave_.on_sync();
  EXPECT_EQ(latest(), microseconds(400 + 300));
}

}  // namespace
}  // namespace cansync::test
