// CANsync_UPDOWNLOAD_SL, sentence by sentence of section 4.25 of the application manual.
#include "slave_rig.h"

namespace cansync::client::function_blocks {
namespace {

class UpdownloadSl : public SlaveBlockTest {
 protected:
  UpdownloadSl() { block.x_EN = true; }
  void enabled() {
    ASSERT_TRUE(call_until(block, [&] { return daemon->blocks; })) << block.error();
  }
  /// Begins a block and waits for the block's answer.
  FakeSlaveDaemon::Answer begin(std::uint64_t number, bool download, std::uint16_t length,
                                bool whole = true) {
    const std::size_t count = daemon->answers.size() + 1;
    cansync_slave_BlockJob job = daemon->block(number, cansync_slave_BLOCK_BEGUN);
    job.download = download;
    job.length = length;
    job.whole = whole;
    daemon->write(job);
    EXPECT_TRUE(call_until(block, [&] { return daemon->answers.size() >= count; })) << block.error();
    EXPECT_EQ(daemon->answers.back().sample.job, number);
    return daemon->answers.back();
  }
  void complete(std::uint64_t number, std::vector<std::uint8_t> data) {
    const std::size_t count = daemon->answers.size() + 1;
    daemon->write(daemon->block(number, cansync_slave_BLOCK_COMPLETE), std::move(data));
    ASSERT_TRUE(call_until(block, [&] { return daemon->answers.size() >= count; }));
    EXPECT_EQ(daemon->answers.back().sample.kind, cansync_slave_ANSWER_BLOCK_TAKEN);
  }
  void end(std::uint64_t number, cansync_slave_BlockResult result = cansync_slave_BLOCK_DONE) {
    cansync_slave_BlockJob job = daemon->block(number, cansync_slave_BLOCK_ENDED);
    job.result = result;
    daemon->write(job);
  }
  UPDOWNLOAD_SL block{connection};
};

// "If input t_TIME is not assigned, this yields a preset monitoring time of 30 s."
TEST_F(UpdownloadSl, MonitoringTimeIsThirtySecondsByDefault) {
  EXPECT_EQ(block.t_TIME, std::chrono::seconds(30));
  EXPECT_THROW(UPDOWNLOAD_SL{connection}, SetupError);
}

// "Output x_ORDER_ACTIV indicates with TRUE that a job is present. ... with a download job, x_UPDOWN = TRUE."
TEST_F(UpdownloadSl, ADownloadOfOneBlockLiesInTheArray) {
  enabled();
  EXPECT_FALSE(block.x_ORDER_ACTIV || block.x_BUSY || block.x_OK);
  EXPECT_EQ(begin(1, true, 8).sample.kind, cansync_slave_ANSWER_BLOCK_ALLOWED);
  EXPECT_TRUE(block.x_ORDER_ACTIV && block.x_BUSY && block.x_UPDOWN);
  EXPECT_EQ(block.u_LENGTH, 2);
  complete(1, {0x78, 0x56, 0x34, 0x12, 0xFE, 0xFF, 0xFF, 0xFF});
  EXPECT_FALSE(block.x_OK) << "the last answer was not on the bus yet";
  end(1);
  ASSERT_TRUE(call_until(block, [&] { return block.x_OK; }));
  EXPECT_EQ(block.a_DOWNLOAD[0], 0x12345678);
  EXPECT_EQ(block.a_DOWNLOAD[1], -2);
  EXPECT_EQ(block.u_TRANSFERRED, 2);
  EXPECT_FALSE(block.x_ORDER_ACTIV || block.x_BUSY || block.x_ERR);
}

// "The system then expects the data for the upload in field elements a_Uploadwerte[0] ..."
TEST_F(UpdownloadSl, AnUploadOfOneBlockComesFromTheArray) {
  block.a_UPLOAD[0] = 0x12345678;
  block.a_UPLOAD[1] = 5;
  enabled();
  EXPECT_EQ(begin(3, false, 6).data, (std::vector<std::uint8_t>{0x78, 0x56, 0x34, 0x12, 5, 0}));
  EXPECT_FALSE(block.x_UPDOWN);
  EXPECT_EQ(block.u_LENGTH, 2);
  end(3);
  EXPECT_TRUE(call_until(block, [&] { return block.x_OK; }));
  EXPECT_EQ(begin(4, false, 0).data.size(), 300u) << "left to the slave: a whole block";
}

// "In the case of an upload or download job that is larger than 75 32-bit values, the system transfers
// correspondingly more message frame blocks and displays at u_LENGTH the number of 32-bit values of the
// currently transferred message frame block."
TEST_F(UpdownloadSl, SeveralBlocksAreOneJob) {
  enabled();
  (void)begin(1, true, 300);
  EXPECT_EQ(block.u_LENGTH, 75);
  complete(1, std::vector<std::uint8_t>(300, 1));
  end(1);
  call_often(block);
  EXPECT_TRUE(block.x_BUSY) << "another one may follow a full block";
  (void)begin(2, true, 4);
  EXPECT_EQ(block.u_LENGTH, 1);
  complete(2, {9, 0, 0, 0});
  end(2);
  ASSERT_TRUE(call_until(block, [&] { return block.x_OK; }));
  EXPECT_EQ(block.u_TRANSFERRED, 76);
  EXPECT_EQ(block.a_DOWNLOAD[74], 0x01010101);
  EXPECT_EQ(block.a_DOWNLOAD[75], 9);
  // The next job begins at [0] again.
  (void)begin(3, true, 4);
  EXPECT_FALSE(block.x_OK);
  complete(3, {7, 0, 0, 0});
  EXPECT_EQ(block.a_DOWNLOAD[0], 7);
}

TEST_F(UpdownloadSl, AJobOfFullBlocksEndsWhenNoneFollows) {
  enabled();
  (void)begin(1, false, 300);
  end(1);
  ASSERT_TRUE(call_until(block, [&] { return block.u_TRANSFERRED == 75; }));
  EXPECT_TRUE(block.x_BUSY);
  now += block.t_NEXT - std::chrono::milliseconds(1);
  block.call(now);
  EXPECT_FALSE(block.x_OK);
  now += std::chrono::milliseconds(1);
  block.call(now);
  EXPECT_TRUE(block.x_OK);
  EXPECT_FALSE(block.x_BUSY);
}

// "If the download job or the upload job is not completely processed within the monitoring time, the system
// sets bit 0 in the error word."
TEST_F(UpdownloadSl, TimeoutIsBitZeroAndNeedsAReset) {
  enabled();
  (void)begin(1, true, 8);
  now += std::chrono::seconds(30) - std::chrono::milliseconds(1);
  block.call(now);
  EXPECT_FALSE(block.x_ERR);
  now += std::chrono::milliseconds(1);
  block.call(now);
  EXPECT_TRUE(block.x_ERR);
  EXPECT_EQ(block.w_ERR, 0x0001);
  EXPECT_FALSE(block.x_OK || block.x_BUSY);
  EXPECT_TRUE(call_until(block, [&] { return !daemon->blocks; }));
  call_often(block);
  EXPECT_FALSE(daemon->blocks);
  block.x_RESET = true;
  block.call(now);
  EXPECT_FALSE(block.x_ERR);
  EXPECT_EQ(block.w_ERR, 0);
  block.x_RESET = false;
  enabled();
}

// "If x_EN is set to FALSE before the upload or download job is completed, it is assumed that it was
// cancelled deliberately."
TEST_F(UpdownloadSl, EnableTakenAwayCancelsAndNeedsAReset) {
  enabled();
  (void)begin(1, true, 8);
  block.x_EN = false;
  block.call(now);
  EXPECT_FALSE(block.x_BUSY || block.x_ORDER_ACTIV || block.x_OK || block.x_ERR);
  ASSERT_TRUE(call_until(block, [&] { return !daemon->blocks; }));
  block.x_EN = true;
  call_often(block);
  EXPECT_FALSE(daemon->blocks);
  block.x_RESET = true;
  block.call(now);
  block.x_RESET = false;
  enabled();
}

TEST_F(UpdownloadSl, ACancelOfTheMasterEndsTheJobWithoutAnErrorAndTheNextMayCome) {
  enabled();
  (void)begin(1, true, 8);
  end(1, cansync_slave_BLOCK_CANCELLED);
  ASSERT_TRUE(call_until(block, [&] { return !block.x_BUSY; }));
  EXPECT_FALSE(block.x_OK || block.x_ERR);
  EXPECT_NE(block.error(), "");
  EXPECT_EQ(begin(2, true, 4).sample.kind, cansync_slave_ANSWER_BLOCK_ALLOWED);
  end(2, cansync_slave_BLOCK_TIMED_OUT);
  ASSERT_TRUE(call_until(block, [&] { return block.x_ERR; }));
  EXPECT_EQ(block.w_ERR, 0x0001);
}

// "carry out an upload or a download in the block 1 range".
TEST_F(UpdownloadSl, WhatMovesTelegramByTelegramIsRefused) {
  enabled();
  const auto answer = begin(1, true, 301, false);
  EXPECT_EQ(answer.sample.kind, cansync_slave_ANSWER_BLOCK_REFUSED);
  EXPECT_EQ(answer.sample.error, 0x0104);
  EXPECT_FALSE(block.x_BUSY);
}

/// A program and its stand-by both run: a block belongs to the one that the daemon asks.
TEST_F(UpdownloadSl, BlocksOfAnotherApplicationAreNotTaken) {
  enabled();
  daemon->name_application(true);
  EXPECT_TRUE(call_until(block, [&] { return block.x_STANDBY; }));
  cansync_slave_BlockJob others = daemon->given(daemon->block(1, cansync_slave_BLOCK_BEGUN), true);
  others.download = true;
  others.length = 4;
  daemon->write(others);
  daemon->write(daemon->given(daemon->block(1, cansync_slave_BLOCK_COMPLETE), true), {1, 2, 3, 4});
  daemon->write(daemon->given(daemon->block(1, cansync_slave_BLOCK_ENDED), true));
  call_often(block);
  EXPECT_FALSE(block.x_ORDER_ACTIV || block.x_BUSY || block.x_OK);
  EXPECT_EQ(block.a_DOWNLOAD[0], 0);
  EXPECT_TRUE(daemon->answers.empty());
}

}  // namespace
}  // namespace cansync::client::function_blocks
