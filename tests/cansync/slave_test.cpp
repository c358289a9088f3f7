#include "cansync/slave.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace cansync {
namespace {

constexpr std::uint8_t kNumber = 5;

// Frames are written byte by byte from the manual's tables, so that the slave is held to the wire and not to
// the project's own encoder.
can::Frame frame(std::uint32_t id, std::initializer_list<std::uint8_t> bytes) {
  can::Frame result;
  result.id = id;
  result.dlc = static_cast<std::uint8_t>(bytes.size());
  std::copy(bytes.begin(), bytes.end(), result.data.begin());
  return result;
}
can::Frame command(std::initializer_list<std::uint8_t> bytes) {
  return frame(0x500 + kNumber, bytes);
}
can::Frame response(std::initializer_list<std::uint8_t> bytes) {
  return frame(0x580 + kNumber, bytes);
}

/// Notes every call, answers as told.
class Recorder : public SlaveApplication {
 public:
  ParameterAnswer read_parameter(ParameterNumber number, Element element, SubSlave sub) noexcept override {
    note("read " + std::to_string(number.value()) + "." + std::to_string(element.value()) + "/" +
         std::to_string(sub.value));
    return parameter;
  }
  ParameterAnswer write_parameter(ParameterNumber number, Element, SubSlave sub, bool doubleword,
                                  std::uint32_t value) noexcept override {
    note("write " + std::to_string(number.value()) + "/" + std::to_string(sub.value) +
         (doubleword ? " dw " : " w ") + std::to_string(value));
    return parameter;
  }
  void parameter_dropped() noexcept override { note("dropped"); }
  BlockAnswer begin_block(const TransferInitialise& initialise) noexcept override {
    note("begin " + std::to_string(initialise.address));
    return block;
  }
  BlockAnswer read_block(std::uint16_t offset, std::span<std::uint8_t> out) noexcept override {
    note("get " + std::to_string(offset) + "+" + std::to_string(out.size()));
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = static_cast<std::uint8_t>(offset + i + 1);
    return block;
  }
  BlockAnswer write_block(std::uint16_t offset, std::span<const std::uint8_t> data) noexcept override {
    note("put " + std::to_string(offset) + "+" + std::to_string(data.size()));
    if (!block.busy) taken.insert(taken.end(), data.begin(), data.end());
    return block;
  }
  void end_block(bool complete) noexcept override { note(complete ? "complete" : "cancelled"); }
  void sync_activated() noexcept override { note("activated"); }
  void control_word(std::uint16_t word) noexcept override { note("control " + std::to_string(word)); }
  void action(std::uint8_t number, std::uint8_t byte, std::uint16_t word) noexcept override {
    note("action " + std::to_string(number) + " " + std::to_string(byte) + " " + std::to_string(word));
  }

  void note(const std::string& text) { calls += (calls.empty() ? "" : ", ") + text; }
  std::string take() { return std::exchange(calls, ""); }

  ParameterAnswer parameter;
  BlockAnswer block;
  std::vector<std::uint8_t> taken;
  std::string calls;
};

class SlaveTest : public ::testing::Test {
 protected:
  explicit SlaveTest(SlaveSideSettings settings = {}) : slave_(numbered(settings), application_) {}

  static SlaveSideSettings numbered(SlaveSideSettings settings) {
    settings.number = *SlaveNumber::from(kNumber);
    return settings;
  }
  void set_up() {
    EXPECT_TRUE(slave_.control(ControlCommand::handshake));
    EXPECT_TRUE(slave_.control(ControlCommand::take_over_initialisation));
    EXPECT_TRUE(slave_.control(ControlCommand::start_synchronous));
    EXPECT_EQ(slave_.state(), State::setting_up_slave);
  }
  void activate() {
    set_up();
    EXPECT_TRUE(slave_.control(ControlCommand::enable_active));
    EXPECT_EQ(slave_.state(), State::active_slave);
  }
  std::optional<can::Frame> send(const can::Frame& sent) { return slave_.receive(sent); }

  Recorder application_;
  Slave slave_;
};

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
  EXPECT_EQ(application_.take(), "") << "commands 2..127 are reserved";
}

TEST_F(SlaveTest, ActivationIsRememberedUntilColdRestart) {
  set_up();
  EXPECT_FALSE(slave_.sync_activated());
  send(frame(0x010, {0x20, 0, 0, 0, 2, 0, 0, 0}));
  EXPECT_FALSE(slave_.sync_activated()) << "another data byte";
  send(frame(0x010, {0x20, 0, 0, 0, 2, 1, 0, 0}));
  EXPECT_TRUE(slave_.sync_activated());
  EXPECT_EQ(application_.take(), "activated");
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

// --- transfers

can::Frame initialise(bool download, std::uint16_t length, std::uint32_t address, std::uint8_t sub = 0) {
  return command({static_cast<std::uint8_t>((download ? 0xD0 : 0x90) | (length >> 8)),
                  static_cast<std::uint8_t>(length & 0xFF), static_cast<std::uint8_t>(address & 0xFF),
                  static_cast<std::uint8_t>(address >> 8), 0, 0, sub, 0});
}

TEST_F(SlaveTest, UploadBlockByBlockWithPaddedEnd) {
  set_up();
  EXPECT_EQ(send(initialise(false, 14, 0x100)), response({0x80, 0x00}));
  EXPECT_TRUE(slave_.transfer_open());
  EXPECT_EQ(send(command({0xA0, 0})), response({0x80, 0, 1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(send(command({0xA0, 6})), response({0x80, 6, 7, 8, 9, 10, 11, 12}));
  EXPECT_EQ(send(command({0xB0, 12})), response({0x80, 12, 13, 14, 0, 0, 0, 0}));
  EXPECT_FALSE(slave_.transfer_open());
  EXPECT_EQ(application_.take(), "begin 256, get 0+6, get 6+6, get 12+2, complete");
}

TEST_F(SlaveTest, DownloadTakesOnlyTheBytesThatAreDue) {
  set_up();
  EXPECT_EQ(send(initialise(true, 8, 0x200)), response({0x80, 0x00}));
  EXPECT_EQ(send(command({0xE0, 0, 1, 2, 3, 4, 5, 6})), response({0x80, 0}));
  EXPECT_EQ(send(command({0xF0, 6, 7, 8, 99, 99, 99, 99})), response({0x80, 6}));
  EXPECT_EQ(application_.taken, (std::vector<std::uint8_t>{1, 2, 3, 4, 5, 6, 7, 8}));
  EXPECT_EQ(application_.take(), "begin 512, put 0+6, put 6+2, complete");
}

TEST_F(SlaveTest, OffsetsOver255StandInTheUpperBits) {
  set_up();
  send(initialise(false, 300, 0x100));
  for (unsigned offset = 0; offset < 294; offset += 6) {
    const auto high = static_cast<std::uint8_t>(0xA0 | (offset >> 8));
    const auto low = static_cast<std::uint8_t>(offset & 0xFF);
    const auto answer = send(command({high, low}));
    ASSERT_TRUE(answer.has_value());
    ASSERT_EQ(answer->data[0], 0x80 | (offset >> 8));
    ASSERT_EQ(answer->data[1], low);
  }
  EXPECT_EQ(send(command({0xB1, 0x26}))->data[0], 0x81);
  EXPECT_FALSE(slave_.transfer_open());
}

TEST_F(SlaveTest, SlaveMayFixTheUploadLength) {
  set_up();
  application_.block.length = 10;
  EXPECT_EQ(send(initialise(false, 30, 0x100)), response({0x80, 10}));
  application_.block.length = 0;
  EXPECT_EQ(send(command({0xA0, 0}))->dlc, 8);
  EXPECT_EQ(send(command({0xB0, 6})), response({0x80, 6, 7, 8, 9, 10, 0, 0}));
  EXPECT_EQ(application_.take(), "begin 256, get 0+6, get 6+4, complete");
}

TEST_F(SlaveTest, LengthOfADownloadIsTheMasters) {
  set_up();
  application_.block.length = 10;
  EXPECT_EQ(send(initialise(true, 12, 0x100)), response({0x80, 0}));
  EXPECT_EQ(send(command({0xE0, 0, 1, 2, 3, 4, 5, 6})), response({0x80, 0}));
  EXPECT_EQ(send(command({0xF0, 6, 1, 2, 3, 4, 5, 6})), response({0x80, 6}));
}

TEST_F(SlaveTest, UploadOfLengthZeroNeedsASlaveThatFixesIt) {
  set_up();
  EXPECT_EQ(send(initialise(false, 0, 0x100)), response({0xA0, 0, 0x04, 0x01}));
  EXPECT_EQ(application_.take(), "begin 256, cancelled");
  application_.block.length = 6;
  EXPECT_EQ(send(initialise(false, 0, 0x100)), response({0x80, 6}));
  EXPECT_EQ(send(initialise(true, 0, 0x100)), response({0xA0, 0, 0x04, 0x01}));
}

TEST_F(SlaveTest, ImpossibleLengthFromTheApplicationIsRefused) {
  set_up();
  application_.block.length = 5000;
  EXPECT_EQ(send(initialise(false, 12, 0x100)), response({0xA0, 0, 0x04, 0x01}));
  EXPECT_FALSE(slave_.transfer_open());
}

TEST_F(SlaveTest, GapInTheOffsetsNamesTheBlockThatIsExpected) {
  set_up();
  send(initialise(true, 18, 0x100));
  send(command({0xE0, 0, 1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(send(command({0xF0, 12, 1, 2, 3, 4, 5, 6})), response({0xA0, 6, 0x00, 0x01}));
  EXPECT_TRUE(slave_.transfer_open());
  EXPECT_EQ(send(command({0xE0, 6, 1, 2, 3, 4, 5, 6})), response({0x80, 6})) << "the master may go on";
}

TEST_F(SlaveTest, EndTooEarlyAndTooLate) {
  set_up();
  send(initialise(false, 12, 0x100));
  EXPECT_EQ(send(command({0xB0, 0})), response({0xA0, 0, 0x02, 0x01}));
  send(command({0xA0, 0}));
  EXPECT_EQ(send(command({0xA0, 6})), response({0xA0, 6, 0x01, 0x01}));
  EXPECT_EQ(send(command({0xB0, 6}))->dlc, 8);
}

TEST_F(SlaveTest, BlockWithoutInitialiseOrInTheOtherDirection) {
  set_up();
  EXPECT_EQ(send(command({0xA0, 0})), response({0xA0, 0, 0x08, 0x01}));
  EXPECT_EQ(send(command({0xE0, 0, 0, 0, 0, 0, 0, 0})), response({0xA0, 0, 0x08, 0x01}));
  send(initialise(false, 12, 0x100));
  EXPECT_EQ(send(command({0xE0, 0, 0, 0, 0, 0, 0, 0})), response({0xA0, 0, 0x08, 0x01}));
  EXPECT_EQ(application_.take(), "begin 256");
}

TEST_F(SlaveTest, LengthOver300Bytes) {
  set_up();
  EXPECT_EQ(send(initialise(true, 301, 0x100)), response({0xA0, 0, 0x02, 0x00}));
  EXPECT_EQ(send(initialise(false, 4092, 0x100)), response({0xA0, 0, 0x02, 0x00}));
  EXPECT_EQ(application_.take(), "");
  EXPECT_EQ(send(initialise(true, 300, 0x100)), response({0x80, 0}));
}

class SmallBlockTest : public SlaveTest {
 protected:
  static SlaveSideSettings settings() {
    SlaveSideSettings result;
    result.block_limit = 60;
    return result;
  }
  SmallBlockTest() : SlaveTest(settings()) {}
};

TEST_F(SmallBlockTest, LengthOverTheSlavesOwnLimit) {
  set_up();
  EXPECT_EQ(send(initialise(true, 61, 0x100)), response({0xA0, 0, 0x07, 0x01}));
  EXPECT_EQ(send(initialise(true, 60, 0x100)), response({0x80, 0}));
}

TEST_F(SlaveTest, ErrorsOfTheApplicationAreHandedOn) {
  set_up();
  application_.block.error = TransferError::address_not_allowed;
  EXPECT_EQ(send(initialise(false, 12, 0x10)), response({0xA0, 0, 0x05, 0x01}));
  EXPECT_FALSE(slave_.transfer_open());
  application_.block.error = TransferError::none;
  send(initialise(true, 12, 0x100));
  application_.block.error = TransferError::not_possible;
  EXPECT_EQ(send(command({0xE0, 0, 0, 0, 0, 0, 0, 0})), response({0xA0, 0, 0x04, 0x01}));
  EXPECT_TRUE(slave_.transfer_open());
  application_.block.error = TransferError::cancelled_by_slave;
  EXPECT_EQ(send(command({0xE0, 0, 0, 0, 0, 0, 0, 0})), response({0xA0, 0, 0x03, 0x01}));
  EXPECT_FALSE(slave_.transfer_open());
}

TEST_F(SlaveTest, BusyInEveryPhaseOfATransfer) {
  set_up();
  application_.block.busy = true;
  EXPECT_EQ(send(initialise(false, 6, 0x100)), response({0xC0, 0}));
  EXPECT_FALSE(slave_.transfer_open());
  application_.block.busy = false;
  EXPECT_EQ(send(initialise(false, 6, 0x100)), response({0x80, 0}));
  application_.block.busy = true;
  EXPECT_EQ(send(command({0xB0, 0})), response({0xC0, 0}));
  application_.block.busy = false;
  EXPECT_EQ(send(command({0xB0, 0}))->data[0], 0x80);
  EXPECT_EQ(application_.take(), "begin 256, begin 256, get 0+6, get 0+6, complete");
}

TEST_F(SlaveTest, RepeatedTelegramGetsTheSameAnswerOnce) {
  set_up();
  send(initialise(true, 12, 0x100));
  EXPECT_EQ(send(initialise(true, 12, 0x100)), response({0x80, 0}));
  send(command({0xE0, 0, 1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(send(command({0xE0, 0, 1, 2, 3, 4, 5, 6})), response({0x80, 0}));
  send(command({0x71, 0x2D, 0, 0}));  // a parameter job between two transfer telegrams changes nothing
  EXPECT_EQ(send(command({0xE0, 0, 1, 2, 3, 4, 5, 6})), response({0x80, 0}));
  send(command({0xF0, 6, 7, 8, 9, 10, 11, 12}));
  EXPECT_EQ(send(command({0xF0, 6, 7, 8, 9, 10, 11, 12})), response({0x80, 6}));
  EXPECT_EQ(application_.taken, (std::vector<std::uint8_t>{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}));
  EXPECT_EQ(application_.take(), "begin 256, put 0+6, read 301.7/0, put 6+6, complete");
}

TEST_F(SlaveTest, RepeatedUploadTelegramBringsTheSameData) {
  set_up();
  send(initialise(false, 6, 0x100));
  const auto first = send(command({0xB0, 0}));
  EXPECT_EQ(send(command({0xB0, 0})), first);
  EXPECT_EQ(application_.take(), "begin 256, get 0+6, complete");
}

TEST_F(SlaveTest, ABlockThatWasDroppedIsBegunAnewByTheSameInitialise) {
  set_up();
  send(initialise(true, 12, 0x100));
  application_.block.error = TransferError::cancelled_by_slave;
  EXPECT_EQ(send(command({0xE0, 0, 1, 2, 3, 4, 5, 6})), response({0xA0, 0, 0x03, 0x01}));
  application_.block.error = TransferError::none;
  EXPECT_EQ(send(initialise(true, 12, 0x100)), response({0x80, 0}));
  EXPECT_TRUE(slave_.transfer_open());
  EXPECT_EQ(application_.take(), "begin 256, put 0+6, cancelled, begin 256");

  EXPECT_EQ(send(initialise(true, 301, 0x200)), response({0xA0, 0, 0x02, 0x00}))
      << "replaces, and is too long";
  EXPECT_EQ(send(initialise(true, 12, 0x100)), response({0x80, 0}));
  EXPECT_EQ(send(command({0xE0, 0, 1, 2, 3, 4, 5, 6})), response({0x80, 0}));
  EXPECT_EQ(application_.take(), "cancelled, begin 256, put 0+6");
}

TEST_F(SlaveTest, CancelIsAcknowledgedWithTwoBytes) {
  set_up();
  EXPECT_EQ(send(initialise(false, 0, 0)), response({0x80, 0})) << "also with nothing to cancel";
  send(initialise(true, 12, 0x100));
  EXPECT_EQ(send(initialise(false, 0, 0)), response({0x80, 0}));
  EXPECT_FALSE(slave_.transfer_open());
  EXPECT_EQ(application_.take(), "begin 256, cancelled");
  EXPECT_EQ(send(command({0xE0, 0, 1, 2, 3, 4, 5, 6})), response({0xA0, 0, 0x08, 0x01}));
}

TEST_F(SlaveTest, NewInitialiseReplacesTheOpenBlock) {
  set_up();
  send(initialise(true, 12, 0x100));
  application_.block.busy = true;
  send(initialise(true, 12, 0x101));
  application_.block.busy = false;
  EXPECT_EQ(send(initialise(false, 6, 0x102)), response({0x80, 0}));
  EXPECT_EQ(application_.take(), "begin 256, cancelled, begin 257, cancelled, begin 258");
}

TEST_F(SlaveTest, LeavingSynchronousOperationDropsWhatIsOpen) {
  set_up();
  send(initialise(true, 12, 0x100));
  application_.parameter.busy = true;
  send(command({0x71, 0x2D, 0, 0}));
  application_.take();
  EXPECT_TRUE(slave_.control(ControlCommand::cold_restart));
  EXPECT_EQ(application_.take(), "cancelled, dropped");
  EXPECT_FALSE(slave_.transfer_open());
}

}  // namespace
}  // namespace cansync
