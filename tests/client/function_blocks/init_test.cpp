// CANsync_INIT and CANsync_SL_TYP_INIT, section 4.9 of the application manual.
#include "block_rig.h"

namespace cansync::client::function_blocks {
namespace {

class InitTest : public BlockTest {
 protected:
  void finish(INIT& init) {
    ASSERT_TRUE(repeat_until(
        [&] {
          init.call();
          std::this_thread::yield();
        },
        [&] { return init.x_OK || init.x_ERR; }));
  }
  INIT block{options_at(rig.client_place())};
};

// "The system sets output x_OK to TRUE if the CANsync interface module was initialized successfully."
TEST_F(InitTest, ConnectsAndServesTheOtherBlocks) {
  block.us_BAUDRATE = 6;       // 1 Mbit/s
  block.us_SYNC_INTERVAL = 1;  // ms
  block.a_SL_TYP[0] = block.a_SL_TYP[3] = 1;
  EXPECT_FALSE(block.x_OK);
  finish(block);
  EXPECT_TRUE(block.x_OK) << block.error();
  EXPECT_FALSE(block.x_ERR);
  EXPECT_EQ(block.w_ERR, 0);
  PAR_READ_MA read(block.client());
  do_job(read);
  EXPECT_TRUE(read.x_ERR);  // parameter 0 does not exist, says the slave
  EXPECT_EQ(static_cast<std::uint16_t>(read.i_ERR), 0xFFFB);
}

// w_ERR bit 1: "Input error with b_BIT_TIMING0, b_BIT_TIMING1 or us_BAUDRATE".
TEST_F(InitTest, AnotherBaudRateOrIntervalIsBitOne) {
  block.us_BAUDRATE = 5;
  finish(block);
  EXPECT_FALSE(block.x_OK);
  EXPECT_TRUE(block.x_ERR);
  EXPECT_EQ(block.w_ERR, 0x0002);
  INIT interval(options_at(rig.client_place()));
  interval.us_SYNC_INTERVAL = 8;
  finish(interval);
  EXPECT_EQ(interval.w_ERR, 0x0002);
  INIT none(options_at(rig.client_place()));
  none.us_BAUDRATE = 7;
  finish(none);
  EXPECT_EQ(none.w_ERR, 0x0002);
}

// w_ERR bit 0: "Timeout handshaking with the CANsync interface module".
TEST_F(InitTest, NoDaemonIsBitZero) {
  Options nobody = options_at(rig.client_place());
  nobody.bus = "nobody";
  nobody.wait = std::chrono::milliseconds(1);
  INIT alone(nobody);
  finish(alone);
  EXPECT_TRUE(alone.x_ERR);
  EXPECT_EQ(alone.w_ERR, 0x0001);
  EXPECT_NE(alone.error().find("no daemon found"), std::string::npos);
}

// A master's daemon is none for x_SL = TRUE.
TEST_F(InitTest, ADaemonOfAnotherRoleIsBitZero) {
  Options master = options_at(rig.client_place());
  master.wait = std::chrono::milliseconds(1);
  INIT slave(master);
  slave.x_SL = true;
  finish(slave);
  EXPECT_EQ(slave.w_ERR, 0x0001);
}

// "Setting x_SYNC_MODE = TRUE sets synchronous operation."
TEST_F(InitTest, SyncModeSetsTheLineUpUnlessThatIsPast) {
  block.x_SYNC_MODE = true;
  finish(block);
  EXPECT_TRUE(block.x_OK) << block.error();
  rig.release();
  ASSERT_TRUE(client.mode(Mode::stop).wait().ok());
  ASSERT_TRUE(rig.watch([](const auto& status) { return status.option_status == 0x0003; }));
  INIT stopped(options_at(rig.client_place()));
  stopped.x_SYNC_MODE = true;
  finish(stopped);
  EXPECT_TRUE(stopped.x_OK) << stopped.error();
  EXPECT_TRUE(rig.watch([](const auto& status) { return status.option_status == 0x0043; }));
}

class InitCommands : public CommandTest {};

TEST_F(InitCommands, ASyncModeThatIsRefusedIsBitEleven) {
  daemon.set_state(cansync::State::waiting_for_start);
  daemon.refuse_modes(gateway_CAUSE_READ_ONLY);
  INIT block(options_at(places.there));
  block.x_SYNC_MODE = true;
  ASSERT_TRUE(repeat_until(
      [&] {
        block.call();
        std::this_thread::yield();
      },
      [&] { return block.x_OK || block.x_ERR; }));
  EXPECT_EQ(block.w_ERR, 0x0800);
  EXPECT_EQ(block.error().rfind("daemon: ", 0), 0u) << block.error();
  EXPECT_EQ(daemon.commands().size(), 1u);
}

// w_ERR bit 11: "Initialization of CANsync interface module not completed".
TEST_F(InitTest, AMissingSlaveIsBitEleven) {
  INIT missing(options_at(rig.client_place()));
  missing.a_SL_TYP[9] = 1;
  finish(missing);
  EXPECT_EQ(missing.w_ERR, 0x0800);
  EXPECT_NE(missing.error().find("a_SL_TYP[9]"), std::string::npos);
}

}  // namespace
}  // namespace cansync::client::function_blocks
