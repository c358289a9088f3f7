// The slave's side of data transfers, telegram by telegram.
#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "slave_rig.h"

namespace cansync::test {
namespace {

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
}  // namespace cansync::test
