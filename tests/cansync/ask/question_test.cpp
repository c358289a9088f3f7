// What may be asked on a line that nobody knows: whatever a question holds, its frame changes nothing on a
// slave.
#include "cansync/ask/question.h"

#include <gtest/gtest.h>

#include <random>

#include "cansync/telegram/telegram.h"

namespace cansync::ask {
namespace {

/// A question with every field at random.
Question random_question(std::mt19937& chance) {
  const auto slave = *SlaveNumber::from(chance() % kSlaves);
  switch (chance() % 3) {
    case 0:
      return ReadQuestion{slave, *ParameterNumber::from(chance() % 4096)};
    case 1:
      return BlockQuestion{slave, *BlockOffset::from(chance() % 4096), static_cast<std::uint32_t>(chance())};
    default:
      return CloseQuestion{slave};
  }
}

TEST(Question, IsAReadOrTheFirstStepOfAnUploadWhateverItHolds) {
  std::mt19937 chance(1);
  for (int i = 0; i < 100'000; ++i) {
    const Question question = random_question(chance);
    const can::Frame frame = frame_of(question);
    ASSERT_TRUE(frame.is_standard_data());
    ASSERT_EQ(identifier::channel_of(frame.id), identifier::command);
    const Decoded decoded = decode(frame);
    const auto& telegram = std::get<Telegram>(decoded);
    if (const auto* command = std::get_if<ParameterCommand>(&telegram)) {
      ASSERT_EQ(command->kind, ParameterCommand::Kind::read);
      ASSERT_EQ(command->element, kValueElement);
    } else {
      const auto& initialise = std::get<TransferInitialise>(telegram);
      ASSERT_EQ(initialise.direction, TransferInitialise::Direction::upload);
    }
    ASSERT_EQ(asked_slave(question).value(), identifier::participant_of(frame.id));
  }
}

TEST(Question, HasTheBytesOfTheManual) {
  // M 3.2.1.3: read parameter 301 = 0x12D, element 7, sub-slave 0, of slave 5.
  const can::Frame read = frame_of(ReadQuestion{*SlaveNumber::from(5), *ParameterNumber::from(301)});
  EXPECT_EQ(read.id, 0x505u);
  EXPECT_EQ(read.dlc, 4);
  EXPECT_EQ(read.data, (std::array<std::uint8_t, 8>{0x71, 0x2D, 0, 0, 0, 0, 0, 0}));
  // Initialise upload of 300 = 0x12C bytes from 0x100.
  const can::Frame block = frame_of(BlockQuestion{*SlaveNumber::from(5), *BlockOffset::from(300)});
  EXPECT_EQ(block.dlc, 8);
  EXPECT_EQ(block.data, (std::array<std::uint8_t, 8>{0x91, 0x2C, 0x00, 0x01, 0, 0, 0, 0}));
  // Cancel: initialise, upload, length 0, address 0.
  const can::Frame close = frame_of(CloseQuestion{*SlaveNumber::from(5)});
  EXPECT_EQ(close.data, (std::array<std::uint8_t, 8>{0x90, 0, 0, 0, 0, 0, 0, 0}));
}

}  // namespace
}  // namespace cansync::ask
