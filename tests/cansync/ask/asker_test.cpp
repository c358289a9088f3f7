// One question after the other: pace, patience, busy slaves, answers to something else, a master that
// appears.
#include "cansync/ask/asker.h"

#include <gtest/gtest.h>

#include "cansync/telegram/reply_payload.h"

namespace cansync::ask {
namespace {

using std::chrono::milliseconds;

constexpr SlaveNumber kSlave = *SlaveNumber::from(3);
constexpr ParameterNumber kNumber = *ParameterNumber::from(301);

ParameterReply value_reply(ParameterNumber number, std::uint32_t value) {
  ParameterReply reply;
  reply.slave = kSlave;
  reply.number = number;
  put_value(reply, value, false, {});
  return reply;
}

TEST(Asker, ReadsAValue) {
  Asker asker(BitRate::kbit500);
  asker.ask(ReadQuestion{kSlave, kNumber}, milliseconds(10));
  EXPECT_TRUE(asker.take(milliseconds(10)));
  EXPECT_FALSE(asker.take(milliseconds(10)));
  EXPECT_FALSE(asker.answer(milliseconds(10)));
  asker.receive(encode(value_reply(*ParameterNumber::from(302), 7)), milliseconds(11));
  EXPECT_FALSE(asker.answer(milliseconds(11))) << "the answer to another number";
  asker.receive(encode(value_reply(kNumber, 0x8001)), milliseconds(11));
  const auto answer = asker.answer(milliseconds(11));
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->kind, Answer::Kind::value);
  EXPECT_EQ(answer->value, 0x8001u);
}

TEST(Asker, CountsAnswersOfASecondDriveAlsoAfterTheFirstHasEndedTheQuestion) {
  Asker asker(BitRate::mbit1);
  Duration now = milliseconds(0);
  for (unsigned question = 0; question < 3; ++question, now += milliseconds(10)) {
    EXPECT_EQ(asker.answers_too_many(kSlave), question);
    asker.ask(ReadQuestion{kSlave, kNumber}, now);
    ASSERT_TRUE(asker.take(now));
    asker.receive(encode(value_reply(kNumber, 0x8001)), now + milliseconds(1));
    ASSERT_TRUE(asker.answer(now + milliseconds(1)));
    asker.receive(encode(value_reply(kNumber, 0x0007)), now + milliseconds(2));
  }
  EXPECT_EQ(asker.answers_too_many(*SlaveNumber::from(4)), 0u);
}

TEST(Asker, SendsAtMostOneTelegramInAnInterval) {
  Asker asker(BitRate::kbit125);
  asker.ask(ReadQuestion{kSlave, kNumber}, milliseconds(0));
  EXPECT_TRUE(asker.take(milliseconds(0)));
  asker.receive(encode(value_reply(kNumber, 1)), milliseconds(1));
  ASSERT_TRUE(asker.answer(milliseconds(1)));
  asker.ask(ReadQuestion{kSlave, *ParameterNumber::from(302)}, milliseconds(1));
  EXPECT_FALSE(asker.take(milliseconds(7)));
  EXPECT_EQ(asker.next(), milliseconds(8));
  EXPECT_TRUE(asker.take(milliseconds(8)));
}

TEST(Asker, AsksASilentSlaveTwice) {
  Asker asker(BitRate::mbit1);
  asker.ask(ReadQuestion{kSlave, kNumber}, milliseconds(0));
  unsigned sent = 0;
  Duration now{0};
  while (!asker.answer(now)) {
    if (asker.take(now)) ++sent;
    now = std::max<Duration>(asker.next(), now + milliseconds(1));
    ASSERT_LT(now, milliseconds(1000));
  }
  EXPECT_EQ(sent, Asker::kTries);
  EXPECT_EQ(asker.answer(now)->kind, Answer::Kind::silent);
}

TEST(Asker, GivesUpASlaveThatIsBusyForEver) {
  Asker asker(BitRate::mbit1);
  asker.ask(ReadQuestion{kSlave, kNumber}, milliseconds(0));
  ParameterReply busy;
  busy.slave = kSlave;
  busy.number = kNumber;
  put_busy(busy);
  Duration now{0};
  while (!asker.answer(now)) {
    if (asker.take(now)) asker.receive(encode(busy), now + std::chrono::microseconds(200));
    now += milliseconds(1);
    ASSERT_LT(now, milliseconds(4000));
  }
  EXPECT_EQ(asker.answer(now)->kind, Answer::Kind::busy);
  EXPECT_GT(now, Asker::kBusyTime);
}

TEST(Asker, TellsWhyASlaveRefuses) {
  Asker asker(BitRate::mbit1);
  asker.ask(BlockQuestion{kSlave, *BlockOffset::from(4092)}, milliseconds(0));
  ASSERT_TRUE(asker.take(milliseconds(0)));
  asker.receive(encode(value_reply(kNumber, 1)), milliseconds(1));
  EXPECT_FALSE(asker.answer(milliseconds(1))) << "no answer to a transfer";
  TransferReply reply;
  reply.slave = kSlave;
  put_error(reply, TransferError::block_too_long);
  asker.receive(encode(reply), milliseconds(1));
  ASSERT_TRUE(asker.answer(milliseconds(1)));
  EXPECT_EQ(asker.answer(milliseconds(1))->error, 0x0107);
}

TEST(Asker, FallsSilentWhenAMasterIsHeard) {
  for (const std::uint32_t identifier : {0x010u, 0x100u, 0x1FFu, 0x505u}) {
    Asker asker(BitRate::mbit1);
    asker.ask(ReadQuestion{kSlave, kNumber}, milliseconds(0));
    can::Frame frame;
    frame.id = identifier;
    asker.receive(frame, milliseconds(0));
    EXPECT_TRUE(asker.master_heard());
    EXPECT_FALSE(asker.take(milliseconds(1)));
  }
}

TEST(Asker, TakesAFrameAgainThatWasLeftOut) {
  Asker asker(BitRate::mbit1);
  asker.ask(ReadQuestion{kSlave, kNumber}, milliseconds(0));
  ASSERT_TRUE(asker.take(milliseconds(0)));
  asker.left_out();
  EXPECT_FALSE(asker.take(milliseconds(0)));
  EXPECT_TRUE(asker.take(milliseconds(1)));
}

}  // namespace
}  // namespace cansync::ask
