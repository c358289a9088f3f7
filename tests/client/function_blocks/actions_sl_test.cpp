// CANsync_BC_SL, CANsync_CONTROLWORD_SL and CANsync_MODE_SL, sections 4.5, 4.8 and 4.11 of the application
// manual, and CANsync_INIT of a slave, 4.9.
#include "slave_rig.h"

namespace cansync::client::function_blocks {
namespace {

class BcSl : public SlaveBlockTest {};

// "This FB indicates at si_BC_RECEIVED that a broadcast command of the CANsync master was received and
// outputs the command number (us_BC_CMD_NR) as well as the contents (si_BC_BYTE, i_BC_WORD)."
TEST_F(BcSl, ShowsABroadcastForOneCall) {
  BC_SL block(connection);
  block.call();
  EXPECT_EQ(block.si_BC_RECEIVED, 0);
  daemon->action(cansync_slave_ACTION_USER, 200, 0xFE, 0x8001);
  ASSERT_TRUE(call_until(block, [&] { return block.si_BC_RECEIVED == 2; }));
  EXPECT_EQ(block.us_BC_CMD_NR, 200);
  EXPECT_EQ(block.si_BC_BYTE, -2);
  EXPECT_EQ(block.i_BC_WORD, static_cast<INT>(0x8001));
  EXPECT_EQ(block.ud_RECEIPTS, 1u);
  block.call();
  EXPECT_EQ(block.si_BC_RECEIVED, 0);
  EXPECT_EQ(block.ud_RECEIPTS, 0u);
  EXPECT_EQ(block.us_BC_CMD_NR, 200) << "they change with a receipt only";
}

TEST_F(BcSl, AControlWordAndTheActivationAreNotItsAndOfSeveralTheNewestCounts) {
  BC_SL block(connection);
  CONTROLWORD_SL last(connection);
  daemon->action(cansync_slave_ACTION_USER, 130, 1, 1);
  daemon->action(cansync_slave_ACTION_USER, 131, 2, 2);
  daemon->action(cansync_slave_ACTION_SYNC_MODE, 2, 3, 0);
  daemon->action(cansync_slave_ACTION_CONTROL_WORD, 1, 0, 15);
  ASSERT_TRUE(call_until(last, [&] { return last.si_RECEIVED == 2; })) << "all have come";
  block.call();
  EXPECT_EQ(block.ud_RECEIPTS, 2u);
  EXPECT_EQ(block.us_BC_CMD_NR, 131);
  EXPECT_EQ(block.i_BC_WORD, 2);
}

class ControlwordSl : public SlaveBlockTest {};

// "If the CANsync slave receives a control word message frame from the CANsync master, FB
// CANsync_CONTROLWORD_SL outputs the received control word at output w_CONTROLWORD."
TEST_F(ControlwordSl, ShowsTheControlWordForOneCall) {
  CONTROLWORD_SL block(connection);
  daemon->action(cansync_slave_ACTION_CONTROL_WORD, 1, 0, 0x800F);
  ASSERT_TRUE(call_until(block, [&] { return block.si_RECEIVED == 2; }));
  EXPECT_EQ(block.w_CONTROLWORD, 0x800F);
  block.call();
  EXPECT_EQ(block.si_RECEIVED, 0);
  EXPECT_EQ(block.w_CONTROLWORD, 0x800F);
}

// A control word of before would be carried out by a program that has just begun.
TEST_F(ControlwordSl, WhatCameBeforeTheConnectionDoesNotCount) {
  CONTROLWORD_SL there(connection);
  daemon->action(cansync_slave_ACTION_CONTROL_WORD, 1, 0, 7);
  ASSERT_TRUE(call_until(there, [&] { return there.si_RECEIVED == 2; }));
  SlaveConnection later = SlaveConnection::connect(options_at(places.there));
  CONTROLWORD_SL block(later);
  daemon->action(cansync_slave_ACTION_CONTROL_WORD, 1, 0, 8);
  ASSERT_TRUE(call_until(block, [&] { return block.si_RECEIVED == 2; }));
  EXPECT_EQ(block.w_CONTROLWORD, 8);
  EXPECT_EQ(block.ud_RECEIPTS, 1u);
}

class ModeSl : public SlaveBlockTest {
 protected:
  bool shows(WORD status, const BOOL& output) {
    daemon->status.option_status = status;
    daemon->tell();
    return call_until(block, [&] { return output; });
  }
  MODE_SL block{connection};
};

// "The outputs display the current actual status."
TEST_F(ModeSl, ShowsEachState) {
  EXPECT_TRUE(shows(0x0001, block.x_HS_ACTIV));
  EXPECT_TRUE(shows(0x0002, block.x_INIT_POSSIBLE));
  EXPECT_TRUE(shows(0x0003, block.x_WAIT));
  EXPECT_FALSE(block.x_SYNC_MODE_ACTIV);
  EXPECT_TRUE(shows(0x0013, block.x_PREPARE_ACTIV));
  EXPECT_TRUE(block.x_SYNC_MODE_ACTIV);
  EXPECT_FALSE(block.x_CANsync_ACTIV);
  EXPECT_TRUE(shows(0x0020, block.x_CANsync_ACTIV));
  EXPECT_TRUE(block.x_SYNC_MODE_ACTIV && block.x_SL);
  EXPECT_FALSE(block.x_MA || block.x_ASYNC_MODE_ACTIV || block.x_PREPARE_ACTIV || block.x_WAIT);
}

// "The inputs correspond to commands."
TEST_F(ModeSl, InputsThatRiseAreCommandsOneAfterTheOther) {
  ASSERT_TRUE(shows(0x0003, block.x_WAIT));
  block.x_SYNC_MODE = block.x_CANsync_RUN = block.x_SET_INIT_DATA = true;
  ASSERT_TRUE(call_until(block, [&] { return block.x_CANsync_ACTIV; })) << block.error();
  ASSERT_EQ(daemon->commands.size(), 2u);
  EXPECT_EQ(daemon->commands[0].mode, cansync_slave_SLAVE_MODE_SETUP);
  EXPECT_EQ(daemon->commands[1].mode, cansync_slave_SLAVE_MODE_RUN);
  block.x_RESET_SOFTWARE = true;
  ASSERT_TRUE(call_until(block, [&] { return block.x_WAIT; })) << block.error();
  call_often(block);
  ASSERT_EQ(daemon->commands.size(), 3u) << "each input once: x_SYNC_MODE stays TRUE";
  EXPECT_EQ(daemon->commands[2].mode, cansync_slave_SLAVE_MODE_RESTART);
  block.x_SYNC_MODE = block.x_CANsync_RUN = false;
  block.call();
  block.x_SYNC_MODE = block.x_CANsync_RUN = true;
  ASSERT_TRUE(call_until(block, [&] { return block.x_CANsync_ACTIV; })) << block.error();
  block.x_RESET_CANsync_CONTROLLER = true;
  ASSERT_TRUE(call_until(block, [&] { return daemon->commands.size() == 6; }));
  EXPECT_EQ(daemon->commands[5].mode, cansync_slave_SLAVE_MODE_RESET_CAN);
}

TEST_F(ModeSl, WhatTheSlaveIsAlreadyIsNoCommand) {
  block.x_SYNC_MODE = block.x_CANsync_RUN = true;
  ASSERT_TRUE(call_until(block, [&] { return block.x_CANsync_ACTIV; }));
  call_often(block);
  EXPECT_TRUE(daemon->commands.empty());
  EXPECT_EQ(block.error(), "");
}

TEST_F(ModeSl, ARefusalDropsWhatWaitsBehindItAndReservedInputsAreRefused) {
  ASSERT_TRUE(shows(0x0003, block.x_WAIT));
  daemon->refuses = "it stands in a file";
  block.x_SYNC_MODE = block.x_CANsync_RUN = true;
  ASSERT_TRUE(call_until(block, [&] { return !block.error().empty(); }));
  EXPECT_EQ(block.error(), "daemon: it stands in a file");
  call_often(block);
  EXPECT_EQ(daemon->commands.size(), 1u);
  block.x_ASYNC_MODE0 = true;
  block.call();
  EXPECT_NE(block.error().find("reserved"), std::string::npos);
}

TEST_F(ModeSl, WithoutADaemonNothingIsActive) {
  ASSERT_TRUE(call_until(block, [&] { return block.x_SL; }));
  daemon.reset();
  ASSERT_TRUE(repeat_until([&] { block.call(); }, [&] { return !block.x_SL; }));
  EXPECT_FALSE(block.x_CANsync_ACTIV);
  EXPECT_NE(block.error(), "");
}

class InitSl : public SlaveBlockTest {
 protected:
  void finish(INIT& init) {
    init.x_SL = true;
    ASSERT_TRUE(repeat_until(
        [&] {
          init.call();
          std::this_thread::yield();
        },
        [&] { return init.x_OK || init.x_ERR; }));
  }
};

// x_SL TRUE: slave; "a_SL_TYP" means nothing then.
TEST_F(InitSl, ConnectsToTheDaemonOfASlave) {
  INIT block(options_at(places.there));
  block.us_BAUDRATE = 6;
  block.us_SYNC_INTERVAL = 1;
  block.a_SL_TYP[9] = 1;
  finish(block);
  EXPECT_TRUE(block.x_OK) << block.error();
  MODE_SL mode(block.slave());
  mode.call();
  EXPECT_TRUE(mode.x_CANsync_ACTIV);
}

TEST_F(InitSl, AnotherBaudRateIsBitOneAndNoDaemonBitZero) {
  INIT block(options_at(places.there));
  block.us_BAUDRATE = 5;
  finish(block);
  EXPECT_EQ(block.w_ERR, 0x0002);
  Options nobody = options_at(places.there);
  nobody.bus = "nobody";
  nobody.wait = std::chrono::milliseconds(1);
  INIT alone(nobody);
  finish(alone);
  EXPECT_EQ(alone.w_ERR, 0x0001);
  EXPECT_NE(alone.error(), "");
}

}  // namespace
}  // namespace cansync::client::function_blocks
