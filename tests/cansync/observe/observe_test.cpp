#include <gtest/gtest.h>

#include "campaign/dice.h"
#include "cansync/observe/learned.h"
#include "cansync/observe/observer.h"

namespace cansync::observe {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

/// A line at 1 Mbit/s by hand, stamps as starts.
class ObserverTest : public ::testing::Test {
 protected:
  void interval() {
    edge_ += milliseconds(1);
    observer_.sync(edge_);
  }
  void at(int us, const Telegram& telegram) { observer_.frame(edge_ + microseconds(us), encode(telegram)); }
  static ParameterCommand read(unsigned slave, unsigned number) {
    ParameterCommand command;
    command.slave = *SlaveNumber::from(slave);
    command.number = *ParameterNumber::from(number);
    return command;
  }
  static ParameterReply word(const ParameterCommand& command, std::uint16_t value) {
    ParameterReply reply;
    reply.slave = command.slave;
    reply.number = command.number;
    reply.payload_size = 4;
    store_word(reply.payload.data(), value);
    return reply;
  }

  Observer observer_{{Stamps::start, std::nullopt}};
  Duration edge_{milliseconds(5)};
};

TEST_F(ObserverTest, AnEmptyRecordingTellsNothing) {
  const Learned learned = learn(observer_.finish());
  EXPECT_FALSE(learned.bit_rate.known());
  EXPECT_FALSE(learned.slaves.known());
  EXPECT_FALSE(learned.activation.known());
  EXPECT_FALSE(learned.send_margin.known());
}

TEST_F(ObserverTest, AnAnswersTimeCountsFromTheEndOfTheCommand) {
  interval();
  at(300, read(3, 301));
  // A read of 4 bytes has 79 bits and its stuff bits; the answer begins 400 us after the start.
  at(700, word(read(3, 301), 0x8001));
  interval();
  interval();
  const Observation observation = observer_.finish();
  const SlaveUse& slave = observation.slave[3];
  ASSERT_EQ(slave.response.count, 1u);
  EXPECT_GT(slave.response.shortest, microseconds(400 - 97));
  EXPECT_LT(slave.response.shortest, microseconds(400 - 75));
  EXPECT_EQ(slave.response.slow, slave.response.shortest > microseconds(300) ? 1u : 0u);
  ASSERT_EQ(observation.parameters.size(), 1u);
  EXPECT_EQ(observation.parameters[0].value, 0x8001u);
}

TEST_F(ObserverTest, AnAnswerThatFitsNoCommandIsNoneOfIt) {
  interval();
  at(300, read(3, 301));
  at(700, word(read(3, 302), 7));
  interval();
  at(300, read(3, 301));
  const Observation observation = observer_.finish();
  EXPECT_EQ(observation.slave[3].stray, 1u);
  EXPECT_EQ(observation.slave[3].answers, 0u);
  EXPECT_EQ(observation.slave[3].unanswered, 1u);
  EXPECT_EQ(observation.parameters[0].reads, 0u);
}

TEST_F(ObserverTest, TheActivationIsSeenWhenBit15FollowsIt) {
  interval();
  at(300, ActionCommand{SlaveMask::all(), 17, 4, 0});
  constexpr std::uint16_t kWords[] = {0x0001, 0x0001, 0x8001};
  for (const std::uint16_t status : kWords) {
    interval();
    at(300, read(2, 444));
    at(600, word(read(2, 444), status));
  }
  const Learned learned = learn(observer_.finish());
  EXPECT_EQ(learned.activation.certainty, Certainty::seen);
  EXPECT_EQ(learned.activation.value, (Activation{17, 4}));
  EXPECT_EQ(learned.slave[2].status_parameter.certainty, Certainty::seen);
  EXPECT_EQ(learned.slave[2].status_parameter.value, 444);
}

TEST_F(ObserverTest, WithoutBit15TheActivationIsOnlyInferred) {
  interval();
  at(300, ActionCommand{SlaveMask::all(), 17, 4, 0});
  interval();
  at(300, read(2, 444));
  at(600, word(read(2, 444), 0x0001));
  interval();
  const Learned learned = learn(observer_.finish());
  EXPECT_EQ(learned.activation.certainty, Certainty::inferred);
  EXPECT_EQ(learned.slave[2].status_parameter.certainty, Certainty::inferred);
}

TEST_F(ObserverTest, FramesWithoutAnySenseAreReadToTheEnd) {
  cansyncd::campaign::Dice dice(16);
  constexpr std::uint32_t kChannels[] = {0x010, 0x100, 0x180, 0x300, 0x380, 0x500, 0x580, 0x7FF};
  Duration now{};
  for (unsigned i = 0; i < 50'000; ++i) {
    now += dice.chance(10) ? Duration(dice.below(5'000'000'000'000)) : Duration(dice.below(300'000));
    if (dice.chance(100)) observer_.sync(dice.chance(50) ? now / 2 : now);
    can::Frame frame;
    frame.id = dice.one_of(kChannels);
    if (frame.id != identifier::action)
      frame.id |= static_cast<std::uint32_t>(dice.below(dice.chance(900) ? 4 : 128));
    frame.id &= can::kStandardIdentifierMask;
    frame.error = dice.chance(5);
    frame.dlc = static_cast<std::uint8_t>(dice.below(9));
    // Few different bytes, so that answers fit commands and blocks go on.
    for (unsigned b = 0; b < frame.dlc; ++b)
      frame.data[b] = static_cast<std::uint8_t>(dice.chance(700) ? 6 * dice.below(3) : dice.next());
    observer_.frame(now, frame);
  }
  const Observation observation = observer_.finish();
  EXPECT_EQ(observation.frames, 50'000u);
  EXPECT_LE(observation.steps.size(), kMostSteps);
  EXPECT_GT(observation.steps.size(), 1000u);
  EXPECT_LE(observation.parameters.size(), kMostParameters);
  const Learned learned = learn(observation);
  EXPECT_TRUE(learned.slaves.known());
  static_cast<void>(settings_of(learned));
}

TEST_F(ObserverTest, TwoWordsThatMoveAsOneValueAreADoubleword) {
  std::uint32_t value = 0x0001FFF0;
  for (unsigned i = 0; i < 40; ++i) {
    interval();
    value += 2000;
    const auto low = static_cast<std::uint16_t>(value);
    const auto high = static_cast<std::uint16_t>(value >> 16);
    at(300, ReferenceTelegram{Channel::one, 127, 4, {low, high, 5, static_cast<std::uint16_t>(i * 9000)}});
  }
  const Learned learned = learn(observer_.finish());
  const TelegramMapping& mapping = learned.reference_mapping[0].value;
  EXPECT_TRUE(mapping.word[1].high);
  EXPECT_EQ(mapping.word[1].value, mapping.word[0].value);
  EXPECT_FALSE(mapping.word[3].high);
  EXPECT_EQ(learned.polling[0].value.kind, Cursor::Kind::nobody);
  EXPECT_EQ(learned.poll_nobody.value, 127);
}

}  // namespace
}  // namespace cansync::observe
