// CANsync_UPDOWNLOAD_MA, sentence by sentence of section 4.24 of the application manual.
#include "block_rig.h"

namespace cansync::client::function_blocks {
namespace {

class UpDownloadMa : public BlockTest {
 protected:
  UpDownloadMa() {
    block.si_SL_NR = 2;
    block.u_LENGTH = 100;
  }
  void reset() {
    block.x_RESET = true;
    cycle(block, now);
    block.x_RESET = false;
  }
  UPDOWNLOAD_MA block{client};
};

// "x_UPDOWN = FALSE: upload job; x_UPDOWN = TRUE: download job." "The values are output at a_UPLOAD."
TEST_F(UpDownloadMa, DownloadsAndUploadsInSeveralBlocks) {
  EXPECT_EQ(block.us_MAX_NR_OF_COMM, 1);
  for (std::size_t i = 0; i < block.a_DOWNLOAD.size(); ++i)
    block.a_DOWNLOAD[i] = static_cast<DINT>(i * 70001) - 3;
  block.u_LENGTH = 2048;  // 28 blocks of at most 75 values
  block.x_UPDOWN = true;
  block.x_EN = true;
  cycle(block, now);
  EXPECT_TRUE(block.x_BUSY);
  ASSERT_TRUE(run_until(block, [&] { return !block.x_BUSY; }));
  EXPECT_TRUE(block.x_OK) << block.error();
  block.x_EN = false;
  cycle(block, now);
  // "not in block 1 of UPDOWNLOAD_SL": the address is the caller's; low byte first.
  EXPECT_EQ(rig.line().drive(2).memory().contents()[0], 0xFD);
  block.x_UPDOWN = false;
  do_job(block);
  EXPECT_TRUE(block.x_OK) << block.error();
  EXPECT_EQ(block.a_UPLOAD, block.a_DOWNLOAD);
}

TEST_F(UpDownloadMa, OnlyTheLengthAskedForIsTouched) {
  block.a_UPLOAD.fill(77);
  block.u_LENGTH = 3;
  do_job(block);
  EXPECT_TRUE(block.x_OK);
  EXPECT_EQ(block.a_UPLOAD[2], 0);
  EXPECT_EQ(block.a_UPLOAD[3], 77);
}

// Blocks are as long as the slave takes them, 300 bytes at most unless the daemon was told of more.
TEST(UpDownloadMaShortBlocks, ASlaveWithALowerBlockLimitIsReached) {
  cansyncd::Config config = cansyncd::whole_config();
  config.master.slaves[2].block_limit = 120;
  cansyncd::WholeRig rig(config);
  Client client = Client::connect(options_at(rig.client_place()));
  UPDOWNLOAD_MA block(client);
  block.si_SL_NR = 2;
  block.u_LENGTH = 100;
  block.x_UPDOWN = block.x_EN = true;
  block.a_DOWNLOAD[99] = 0x5A;
  ASSERT_TRUE(repeat_until(
      [&] {
        rig.run(2);
        block.call();
      },
      [&] { return block.x_OK || block.x_ERR; }));
  EXPECT_TRUE(block.x_OK) << block.error();
  EXPECT_EQ(rig.line().drive(2).memory().contents()[396], 0x5A);
}

// 3.2.1.3, note 1: "the slave may fix the length". "The system sets x_OK to TRUE if the ... job was carried
// out correctly": 25 of 75 doublewords are not.
TEST_F(UpDownloadMa, AnUploadThatTheSlaveMadeShorterIsAnErrorThatSaysHowMuchCame) {
  rig.line().drive(2).memory().set_upload_length(100);
  rig.line().drive(2).memory().contents()[96] = 0x5A;
  block.a_UPLOAD.fill(77);
  block.u_LENGTH = 75;
  do_job(block);
  EXPECT_FALSE(block.x_OK);
  EXPECT_TRUE(block.x_ERR);
  EXPECT_EQ(block.b_ERR, 0x01);
  EXPECT_FALSE(block.x_ERR_SL);
  EXPECT_EQ(block.u_RECEIVED, 25);
  EXPECT_EQ(block.a_UPLOAD[24], 0x5A);
  EXPECT_EQ(block.a_UPLOAD[25], 77);
  EXPECT_NE(block.error().find("100 of 300 bytes"), std::string::npos) << block.error();
  reset();
  rig.line().drive(2).memory().set_upload_length(0);
  do_job(block);
  EXPECT_TRUE(block.x_OK) << block.error();
  EXPECT_EQ(block.u_RECEIVED, 75);
}

// "If you enter a 0 at u_LENGTH, the system sets bit 1 in error byte b_ERR to TRUE."
TEST_F(UpDownloadMa, LengthZeroIsBitOne) {
  block.u_LENGTH = 0;
  block.x_EN = true;
  cycle(block, now);
  EXPECT_FALSE(block.x_BUSY);
  EXPECT_TRUE(block.x_ERR);
  EXPECT_EQ(block.b_ERR, 0x02);
  EXPECT_FALSE(block.x_ERR_SL);
}

// "If an error occurs in the CANsync slave ..., the system sets x_ERR_SL to TRUE and outputs error word
// w_ERR_SL".
TEST_F(UpDownloadMa, TheSlavesErrorIsInTheErrorWord) {
  block.ud_ADDRESS = 0x7FFFFFFF;
  do_job(block);
  EXPECT_TRUE(block.x_ERR_SL);
  EXPECT_EQ(block.w_ERR_SL, 0x0105);
  EXPECT_TRUE(block.x_ERR);
  EXPECT_EQ(block.b_ERR, 0x01);
  EXPECT_FALSE(block.x_OK);
}

TEST_F(UpDownloadMa, WrongSlaveAndWhatTheDaemonRefusesAreBitZeroWithoutANumber) {
  block.si_SL_NR = 9;
  do_job(block);
  EXPECT_EQ(block.b_ERR, 0x01);
  EXPECT_FALSE(block.x_ERR_SL);
  reset();
  block.si_SL_NR = 1;
  block.ud_ADDRESS = 0x10;
  do_job(block);
  EXPECT_EQ(block.b_ERR, 0x01);
  EXPECT_EQ(block.error().rfind("daemon: address 0x10", 0), 0u) << block.error();
  EXPECT_EQ(block.cause(), RefusalCause::address);
}

// "does not issue the timeout message until time us_MAX_NR_OF_COMM * t_TIME has expired".
TEST_F(UpDownloadMa, TimeoutComesAfterEveryAttempt) {
  block.t_TIME = std::chrono::seconds(1);
  block.us_MAX_NR_OF_COMM = 3;
  block.x_EN = true;
  cycle(block, now);
  cycle(block, now + std::chrono::milliseconds(2999));
  EXPECT_TRUE(block.x_BUSY);
  cycle(block, now + std::chrono::milliseconds(3000));
  EXPECT_FALSE(block.x_BUSY);
  EXPECT_EQ(block.b_ERR, 0x04);
}

TEST_F(UpDownloadMa, ASlaveThatIsBusyTooLongEndsInATimeout) {
  rig.line().drive(2).memory().set_busy_replies(0xFFFFFFFF);
  block.t_TIME = std::chrono::milliseconds(50);
  block.us_MAX_NR_OF_COMM = 2;
  do_job(block);
  EXPECT_EQ(block.b_ERR, 0x04);
  EXPECT_TRUE(block.x_ERR);
}

// "If x_EN is set to FALSE before the ... job is completed, ... You must then reset".
TEST_F(UpDownloadMa, EnableTakenAwayCancelsAndNeedsAReset) {
  block.x_EN = true;
  cycle(block, now);
  block.x_EN = false;
  cycle(block, now);
  EXPECT_FALSE(block.x_BUSY);
  block.x_EN = true;
  cycle(block, now);
  EXPECT_FALSE(block.x_BUSY);
  reset();
  EXPECT_FALSE(block.x_BUSY);
  cycle(block, now);
  EXPECT_TRUE(block.x_BUSY);
  ASSERT_TRUE(run_until(block, [&] { return !block.x_BUSY; }));
  EXPECT_TRUE(block.x_OK) << block.error();
}

/// Against a daemon that refuses the first request for a full queue.
TEST_F(CommandTest, UpDownloadAsksAgainForWhatPassesSoonAndCountsNoAttempt) {
  UPDOWNLOAD_MA block(client);
  block.si_SL_NR = 1;
  block.ud_ADDRESS = FakeDaemon::kFullOnceAddress;
  block.u_LENGTH = 2;
  block.us_MAX_NR_OF_COMM = 1;
  block.x_UPDOWN = true;
  block.x_EN = true;
  ASSERT_TRUE(
      repeat_until([&] { cycle(block, now); }, [&] { return block.cause() == RefusalCause::queue_full; }));
  EXPECT_TRUE(block.x_BUSY && !block.x_ERR);
  for (int i = 0; i < 100; ++i) cycle(block, now);
  EXPECT_TRUE(block.x_BUSY) << "not before its pause is over";
  now += std::chrono::milliseconds(100);
  ASSERT_TRUE(repeat_until([&] { cycle(block, now); }, [&] { return !block.x_BUSY; }));
  EXPECT_TRUE(block.x_OK) << block.error();
  EXPECT_EQ(block.cause(), RefusalCause::none);
}

}  // namespace
}  // namespace cansync::client::function_blocks
