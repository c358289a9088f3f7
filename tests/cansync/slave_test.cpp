#include "cansync/slave/slave.h"

#include <gtest/gtest.h>

#include <optional>

#include "slave_rig.h"

namespace cansync::test {
namespace {

// --- process data

TEST_F(SlaveTest, TakesReferenceValuesFromBothTelegramsWhoeverIsPolled) {
  activate();
  EXPECT_EQ(send(frame(0x100 + 127, {1, 0, 2, 0, 3, 0, 4, 0})), std::nullopt);
  EXPECT_EQ(send(frame(0x180 + 9, {5, 0, 6, 0, 7, 0, 8, 0})), std::nullopt);
  EXPECT_EQ(slave_.references(), (Values{0x20001, 0x40003, 0, 0, 0x60005, 0x80007, 0, 0}));
  EXPECT_TRUE(slave_.reference_fresh(Channel::one));
  EXPECT_TRUE(slave_.reference_fresh(Channel::two));
  slave_.on_sync();
  EXPECT_FALSE(slave_.reference_fresh(Channel::one));
  EXPECT_FALSE(slave_.reference_fresh(Channel::two));
  EXPECT_EQ(slave_.references()[0], 0x20001u);
}

TEST_F(SlaveTest, ShortReferenceTelegramLeavesTheOtherWordsAsTheyWere) {
  activate();
  send(frame(0x17F, {1, 0, 2, 0, 3, 0, 4, 0}));
  slave_.on_sync();
  send(frame(0x17F, {9, 0}));
  EXPECT_EQ(slave_.references()[0], 0x20009u);
  EXPECT_EQ(slave_.references()[1], 0x40003u);
}

TEST_F(SlaveTest, ReferenceTelegramWithoutDataPollsButBringsNoReference) {
  activate();
  slave_.release_actual(Channel::one, {0x01020304});
  EXPECT_EQ(send(frame(0x100 + kNumber, {})), frame(0x300 + kNumber, {4, 3, 2, 1, 0, 0, 0, 0}));
  EXPECT_FALSE(slave_.reference_fresh(Channel::one));
}

TEST_F(SlaveTest, AnswersOnlyTheTelegramThatNamesItAndOnlyWhatWasReleased) {
  activate();
  const Values values = {0x11112222, 0x33334444, 1, 1, 0x55556666, 0x77778888, 1, 1};
  EXPECT_EQ(send(frame(0x100 + kNumber, {0, 0})), std::nullopt) << "nothing was released";
  slave_.release_actual(Channel::one, values);
  EXPECT_EQ(send(frame(0x100 + 4, {0, 0})), std::nullopt) << "another slave is polled";
  EXPECT_EQ(send(frame(0x180 + kNumber, {0, 0})), std::nullopt) << "channel two was not released";
  EXPECT_EQ(send(frame(0x100 + kNumber, {0, 0})),
            frame(0x300 + kNumber, {0x22, 0x22, 0x11, 0x11, 0x44, 0x44, 0x33, 0x33}));
  EXPECT_EQ(send(frame(0x100 + kNumber, {0, 0})), std::nullopt) << "one release is good for one telegram";
  slave_.release_actual(Channel::two, values);
  EXPECT_EQ(send(frame(0x180 + kNumber, {0, 0})),
            frame(0x380 + kNumber, {0x66, 0x66, 0x55, 0x55, 0x88, 0x88, 0x77, 0x77}));
}

TEST_F(SlaveTest, ReleaseEndsWithTheInterval) {
  activate();
  slave_.release_actual(Channel::one, {1});
  slave_.on_sync();
  EXPECT_EQ(send(frame(0x100 + kNumber, {0, 0})), std::nullopt);
}

TEST_F(SlaveTest, ProcessDataWaitsForActiveOperation) {
  set_up();
  slave_.release_actual(Channel::one, {1});
  EXPECT_EQ(send(frame(0x100 + kNumber, {7, 0})), std::nullopt);
  EXPECT_EQ(slave_.references()[0], 0u);
  EXPECT_FALSE(slave_.reference_fresh(Channel::one));
}

TEST_F(SlaveTest, MappingMayChangeWhileRunning) {
  activate();
  ProcessMapping mapping = {};
  mapping[0].word[1] = {true, false, 3};
  slave_.set_reference_mapping(mapping);
  slave_.set_actual_mapping(mapping);
  send(frame(0x17F, {1, 0, 2, 0, 3, 0, 4, 0}));
  EXPECT_EQ(slave_.references(), (Values{0, 0, 0, 2, 0, 0, 0, 0}));
  slave_.release_actual(Channel::one, {1, 2, 3, 0xABCD});
  EXPECT_EQ(send(frame(0x100 + kNumber, {})), frame(0x300 + kNumber, {0, 0, 0xCD, 0xAB, 0, 0, 0, 0}));
}

class ShortActualTest : public SlaveTest {
 protected:
  static SlaveSideSettings settings() {
    SlaveSideSettings result;
    result.full_length = false;
    result.actual_mapping[0] = {};
    result.actual_mapping[0].word[0] = {true, false, 0};
    return result;
  }
  ShortActualTest() : SlaveTest(settings()) {}
};

TEST_F(ShortActualTest, SendsAsManyWordsAsAreMapped) {
  activate();
  slave_.release_actual(Channel::one, {0x99991234});
  EXPECT_EQ(send(frame(0x100 + kNumber, {})), frame(0x300 + kNumber, {0x34, 0x12}));
}

class MonitorTest : public SlaveTest {
 protected:
  static SlaveSideSettings settings() {
    SlaveSideSettings result;
    result.monitored[9] = ProcessMapping{default_mapping(Channel::one), default_mapping(Channel::two)};
    return result;
  }
  MonitorTest() : SlaveTest(settings()) {}
};

TEST_F(MonitorTest, TakesActualValuesOfMonitoredSlavesAlone) {
  activate();
  const SlaveNumber nine = *SlaveNumber::from(9);
  const SlaveNumber eight = *SlaveNumber::from(8);
  EXPECT_EQ(send(frame(0x300 + 9, {1, 0, 2, 0, 3, 0, 4, 0})), std::nullopt);
  EXPECT_EQ(send(frame(0x380 + 9, {5, 0, 0, 0, 0, 0, 0, 0})), std::nullopt);
  send(frame(0x300 + 8, {9, 9, 9, 9, 9, 9, 9, 9}));
  send(frame(0x300 + 9, {}));
  EXPECT_EQ(slave_.monitored(nine), (Values{0x20001, 0x40003, 0, 0, 5, 0, 0, 0}));
  EXPECT_EQ(slave_.monitored_count(nine, Channel::one), 1u);
  EXPECT_EQ(slave_.monitored_count(nine, Channel::two), 1u);
  EXPECT_EQ(slave_.monitored(eight), Values{});
  EXPECT_EQ(slave_.monitored_count(eight, Channel::one), 0u);
}

// --- states and actions

TEST_F(SlaveTest, HearsNothingBeforeSynchronousOperation) {
  EXPECT_EQ(send(command({0x71, 0x2D, 0, 0})), std::nullopt);
  EXPECT_EQ(send(frame(0x010, {0xFF, 0xFF, 0xFF, 0xFF, 1, 0, 7, 0})), std::nullopt);
  EXPECT_TRUE(slave_.control(ControlCommand::handshake));
  EXPECT_EQ(send(command({0x71, 0x2D, 0, 0})), std::nullopt);
  EXPECT_FALSE(slave_.control(ControlCommand::enable_active));
  EXPECT_EQ(application_.take(), "");
}

TEST_F(SlaveTest, ActionCommandsReachTheNamedSlavesWithoutAnAnswer) {
  set_up();
  EXPECT_EQ(send(frame(0x010, {0x20, 0, 0, 0, 1, 0, 0x34, 0x12})), std::nullopt);
  EXPECT_EQ(application_.take(), "control 4660");
  send(frame(0x010, {0xDF, 0xFF, 0xFF, 0xFF, 1, 0, 0x34, 0x12}));
  EXPECT_EQ(application_.take(), "") << "mask bit 5 is not set";
  send(frame(0x010, {0x20, 0, 0, 0, 200, 7, 0x02, 0x01}));
  EXPECT_EQ(application_.take(), "action 200 7 258");
  send(frame(0x010, {0x20, 0, 0, 0, 3, 7, 0x02, 0x01}));
  EXPECT_EQ(application_.take(), "action 3 7 258") << "M 3.2.3.7: all the other commands are entered";
  send(frame(0x010, {0x20, 0, 0, 0, 2, 9, 0x02, 0x01}));
  EXPECT_EQ(application_.take(), "action 2 9 258") << "SYNC mode with other data";
}

TEST_F(SlaveTest, ActivationIsRememberedUntilColdRestart) {
  set_up();
  EXPECT_FALSE(slave_.sync_activated());
  send(frame(0x010, {0x20, 0, 0, 0, 2, 0, 0, 0}));
  EXPECT_FALSE(slave_.sync_activated()) << "another data byte";
  send(frame(0x010, {0x20, 0, 0, 0, 2, 1, 0, 0}));
  EXPECT_TRUE(slave_.sync_activated());
  EXPECT_EQ(application_.take(), "action 2 0 0, activated");
  EXPECT_TRUE(slave_.control(ControlCommand::cold_restart));
  EXPECT_FALSE(slave_.sync_activated());
}

// --- parameters

TEST_F(SlaveTest, ReadRepliesInBothFormatsWithSubSlaveAddress) {
  set_up();
  application_.parameter = {false, ParameterError::none, false, 0x1234};
  EXPECT_EQ(send(command({0x71, 0x2D, 0x42, 0x00})), response({0x01, 0x2D, 0x34, 0x12, 0x42, 0x00}));
  EXPECT_EQ(application_.take(), "read 301.7/66");
  application_.parameter = {false, ParameterError::none, true, 0x12345678};
  EXPECT_EQ(send(command({0x31, 0x2D, 0, 0})), response({0x01, 0x2D, 0x78, 0x56, 0x34, 0x12, 0x00, 0x00}));
  EXPECT_EQ(application_.take(), "read 301.3/0");
}

TEST_F(SlaveTest, WriteRepliesWithTheSubSlaveAddressAlone) {
  set_up();
  EXPECT_EQ(send(command({0x71, 0x90, 0x22, 0x11, 0x05, 0x01})), response({0x01, 0x90, 0x05, 0x01}));
  EXPECT_EQ(application_.take(), "write 400/261 w 4386");
  EXPECT_EQ(send(command({0x71, 0x90, 0x22, 0x11, 0x01, 0x00, 0x00, 0x00})),
            response({0x01, 0x90, 0x00, 0x00}));
  EXPECT_EQ(application_.take(), "write 400/0 dw 69922");
}

TEST_F(SlaveTest, ErrorsCarryTheirCodeAndTheSubSlaveAddress) {
  set_up();
  application_.parameter.error = ParameterError::above_maximum;
  EXPECT_EQ(send(command({0x7F, 0xFF, 0x03, 0x00})), response({0x2F, 0xFF, 0xFD, 0xFF, 0x03, 0x00}));
  EXPECT_EQ(send(command({0x7F, 0xFF, 1, 0, 0x03, 0x00})), response({0x2F, 0xFF, 0xFD, 0xFF, 0x03, 0x00}));
}

TEST_F(SlaveTest, WriteToAnotherElementIsRefusedWithoutAskingTheApplication) {
  set_up();
  EXPECT_EQ(send(command({0x61, 0x90, 1, 0, 0, 0})), response({0x21, 0x90, 0xFC, 0xFF, 0, 0}));
  EXPECT_EQ(application_.take(), "");
}

TEST_F(SlaveTest, BusyIsAnsweredUntilTheApplicationHasTheResult) {
  set_up();
  application_.parameter.busy = true;
  EXPECT_EQ(send(command({0x71, 0x2D, 0, 0})), response({0x41, 0x2D}));
  EXPECT_EQ(send(command({0x71, 0x2D, 0, 0})), response({0x41, 0x2D}));
  application_.parameter = {false, ParameterError::none, false, 9};
  EXPECT_EQ(send(command({0x71, 0x2D, 0, 0})), response({0x01, 0x2D, 9, 0, 0, 0}));
  EXPECT_EQ(application_.take(), "read 301.7/0, read 301.7/0, read 301.7/0");
}

TEST_F(SlaveTest, AnotherCommandDropsTheBusyOneUnanswered) {
  set_up();
  application_.parameter.busy = true;
  send(command({0x71, 0x2D, 0, 0}));
  application_.parameter = {false, ParameterError::none, false, 1};
  EXPECT_EQ(send(command({0x71, 0x2E, 0, 0})), response({0x01, 0x2E, 1, 0, 0, 0}));
  EXPECT_EQ(application_.take(), "read 301.7/0, dropped, read 302.7/0");
}

TEST_F(SlaveTest, CommandsToOtherSlavesAndRepliesAreIgnored) {
  activate();
  EXPECT_EQ(send(frame(0x500 + 6, {0x71, 0x2D, 0, 0})), std::nullopt);
  EXPECT_EQ(send(frame(0x500 + 6, {0x90, 12, 0, 1, 0, 0, 0, 0})), std::nullopt);
  EXPECT_EQ(send(frame(0x580 + kNumber, {0x01, 0x2D, 0, 0})), std::nullopt);
  EXPECT_EQ(send(frame(0x123456, {0})), std::nullopt);
  EXPECT_EQ(application_.take(), "");
}

}  // namespace
}  // namespace cansync::test
