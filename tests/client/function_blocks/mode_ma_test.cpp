// CANsync_MODE_MA, sentence by sentence of section 4.10 of the application manual.
#include "block_rig.h"

namespace cansync::client::function_blocks {
namespace {

class ModeMa : public BlockTest {
 protected:
  MODE_MA block{client};
};

// "If x_CANsync_ACTIV, x_SYNC_MODE_ACTIV and x_MA are set to TRUE, ... the CANsync interface module is a
// master in active synchronous operation." "If all the inputs are FALSE, the system does not execute any
// commands".
TEST_F(ModeMa, ShowsTheStateWithoutACommand) {
  ASSERT_TRUE(run_until(block, [&] { return block.x_CANsync_ACTIV; }));
  EXPECT_TRUE(block.x_SYNC_MODE_ACTIV);
  EXPECT_TRUE(block.x_MA);
  EXPECT_FALSE(block.x_SL || block.x_ASYNC_MODE_ACTIV || block.x_PREPARE_ACTIV || block.x_WAIT ||
               block.x_INIT_POSSIBLE || block.x_HS_ACTIV);
}

// "Setting x_SYNC_MODE = TRUE sets synchronous operation." "After setting the operating mode, you use
// x_CANsync_RUN = TRUE to enable active operation."
TEST_F(ModeMa, SetsUpAndEnablesActiveOperation) {
  rig.release();
  ASSERT_TRUE(client.mode(Mode::stop).wait().ok());
  ASSERT_TRUE(repeat_until([&] { cycle(block, now); }, [&] { return block.x_WAIT; }));
  block.x_SYNC_MODE = true;
  ASSERT_TRUE(repeat_until([&] { cycle(block, now); }, [&] { return block.x_PREPARE_ACTIV; }));
  rig.hold();
  EXPECT_FALSE(block.x_CANsync_ACTIV);
  EXPECT_TRUE(block.x_SYNC_MODE_ACTIV);
  EXPECT_TRUE(block.x_MA);
  // The input stays TRUE: nothing is set up again. The slaves are not ready at once; the command is repeated.
  block.x_CANsync_RUN = true;
  ASSERT_TRUE(repeat_until(
      [&] {
        rig.run(10);
        now += std::chrono::milliseconds(10);
        cycle(block, now);
      },
      [&] { return block.x_CANsync_ACTIV; }));
  EXPECT_EQ(block.error(), "");
}

// "Output x_WAIT indicates with TRUE that the CANsync interface module ... is waiting for the command for
// setting the operating mode."
TEST_F(ModeMa, WaitShowsThatTheLineIsStopped) {
  rig.release();
  ASSERT_TRUE(client.mode(Mode::stop).wait().ok());
  ASSERT_TRUE(repeat_until([&] { cycle(block, now); }, [&] { return block.x_WAIT; }));
  EXPECT_FALSE(block.x_MA || block.x_SYNC_MODE_ACTIV || block.x_CANsync_ACTIV);
  // The command is refused in this state, and says so.
  block.x_CANsync_RUN = true;
  ASSERT_TRUE(repeat_until([&] { cycle(block, now); }, [&] { return !block.error().empty(); }));
  EXPECT_EQ(block.error().rfind("daemon: ", 0), 0u) << block.error();
  EXPECT_EQ(block.cause(), RefusalCause::wrong_state);
  block.x_CANsync_RUN = false;
  block.x_SYNC_MODE = true;
  EXPECT_TRUE(repeat_until([&] { cycle(block, now); }, [&] { return block.x_PREPARE_ACTIV; }));
}

class ModeMaCommands : public CommandTest {
 protected:
  void set_state(cansync::State state) {
    daemon.set_state(state);
    ASSERT_TRUE(
        repeat_until([] { std::this_thread::yield(); },
                     [&] { return client.master_status().option_status == static_cast<WORD>(state); }));
  }
  std::vector<cansync_Mode> modes() {
    std::vector<cansync_Mode> found;
    for (const cansync_Command& command : daemon.commands()) found.push_back(command.mode);
    return found;
  }
  /// x_SYNC_MODE becomes TRUE, and then x_RESET_CANsync_CONTROLLER: what the daemon is told next.
  cansync_Mode next_after_sync_mode() {
    const std::size_t before = daemon.commands().size();
    block.x_SYNC_MODE = true;
    cycle(block, now);
    block.x_RESET_CANsync_CONTROLLER = true;
    return command(block, before + 1).mode;
  }
  MODE_MA block{client};
};

// The boot task of the manual, for a program that starts while the line runs.
TEST_F(ModeMaCommands, ASetUpThatIsPastIsNoCommand) {
  for (const cansync::State state : {cansync::State::active_master, cansync::State::setting_up_master}) {
    set_state(state);
    block.x_SYNC_MODE = block.x_CANsync_RUN = true;
    const std::size_t before = daemon.commands().size();
    EXPECT_EQ(command(block, before + 1).mode, cansync_MODE_RUN);
    for (int i = 0; i < 100; ++i) cycle(block, now);
    EXPECT_EQ(daemon.commands().size(), before + 1);
    block.x_SYNC_MODE = block.x_CANsync_RUN = false;
    cycle(block, now);
  }
  // A line that this program has taken down is set up, whatever the newest status says.
  block.x_RESET_SOFTWARE = true;
  command(block, 3);
  block.x_SYNC_MODE = true;
  EXPECT_EQ(command(block, 4).mode, cansync_MODE_SETUP);
}

TEST_F(ModeMaCommands, RunThatIsWantedAnewWhileTheReplyToTheOneBeforeIsOnItsWayIsGivenAgain) {
  daemon.keep_modes_back(true);
  block.x_CANsync_RUN = true;
  EXPECT_EQ(command(block, 1).mode, cansync_MODE_RUN);
  block.x_CANsync_RUN = false;
  cycle(block, now);
  block.x_CANsync_RUN = true;
  cycle(block, now);
  daemon.keep_modes_back(false);
  EXPECT_EQ(command(block, 2).mode, cansync_MODE_RUN);
}

// What the block took down and somebody has set up since may be another program's.
TEST_F(ModeMaCommands, ALineThatIsBackSinceTheOwnResetIsNotSetUp) {
  set_state(cansync::State::active_master);
  block.x_RESET_SOFTWARE = true;
  EXPECT_EQ(command(block, 1).mode, cansync_MODE_RESTART);
  for (const cansync::State state : {cansync::State::waiting_for_start, cansync::State::active_master}) {
    set_state(state);
    cycle(block, now);
  }
  EXPECT_EQ(next_after_sync_mode(), cansync_MODE_RESET_CAN);
}

TEST_F(ModeMaCommands, ALineThatRunsByTheOwnCommandIsNotSetUp) {
  set_state(cansync::State::active_master);
  block.x_RESET_SOFTWARE = true;
  EXPECT_EQ(command(block, 1).mode, cansync_MODE_RESTART);
  block.x_CANsync_RUN = true;
  EXPECT_EQ(command(block, 2).mode, cansync_MODE_RUN);
  EXPECT_EQ(next_after_sync_mode(), cansync_MODE_RESET_CAN);
}

TEST_F(ModeMaCommands, ALineThatARefusedResetLeftRunningIsNotSetUp) {
  set_state(cansync::State::active_master);
  daemon.refuse_modes(gateway_CAUSE_READ_ONLY);
  block.x_RESET_SOFTWARE = true;
  EXPECT_EQ(command(block, 1).mode, cansync_MODE_RESTART);
  ASSERT_TRUE(
      repeat_until([&] { cycle(block, now); }, [&] { return block.cause() == RefusalCause::read_only; }));
  EXPECT_EQ(next_after_sync_mode(), cansync_MODE_RESET_CAN);
}

// "The inputs correspond to commands."
TEST_F(ModeMaCommands, InputsThatRiseInOneCallAreAllGivenInOrder) {
  set_state(cansync::State::waiting_for_start);
  block.x_RESET_CANsync_CONTROLLER = block.x_RESET_SOFTWARE = block.x_SYNC_MODE = block.x_CANsync_RUN = true;
  command(block, 4);
  EXPECT_EQ(modes(), (std::vector{cansync_MODE_RESET_CAN, cansync_MODE_RESTART, cansync_MODE_SETUP,
                                  cansync_MODE_RUN}));
}

TEST_F(ModeMaCommands, WhatIsRefusedStaysInWordsAndDropsWhatWaitsBehindIt) {
  set_state(cansync::State::waiting_for_start);
  daemon.refuse_modes(gateway_CAUSE_READ_ONLY);
  block.x_RESET_CANsync_CONTROLLER = block.x_SYNC_MODE = true;
  command(block, 1);
  ASSERT_TRUE(
      repeat_until([&] { cycle(block, now); }, [&] { return block.cause() == RefusalCause::read_only; }));
  for (int i = 0; i < 100; ++i) cycle(block, now);
  EXPECT_EQ(block.cause(), RefusalCause::read_only);
  // A command of another client comes after whatever the block had on its way.
  (void)client.mode(Mode::stop).wait();
  EXPECT_EQ(modes(), (std::vector{cansync_MODE_RESET_CAN, cansync_MODE_STOP}));
}

TEST_F(ModeMaCommands, EachInputIsItsCommandOnceForEachRisingEdge) {
  block.x_RESET_SOFTWARE = true;
  EXPECT_EQ(command(block, 1).mode, cansync_MODE_RESTART);
  for (int i = 0; i < 100; ++i) cycle(block, now);
  block.x_RESET_CANsync_CONTROLLER = true;
  EXPECT_EQ(command(block, 2).mode, cansync_MODE_RESET_CAN);
  block.x_RESET_SOFTWARE = block.x_RESET_CANsync_CONTROLLER = false;
  cycle(block, now);
  block.x_RESET_SOFTWARE = true;
  EXPECT_EQ(command(block, 3).mode, cansync_MODE_RESTART);
}

TEST_F(ModeMaCommands, SyncModeAndRunTogetherGoOutInThisOrder) {
  set_state(cansync::State::waiting_for_start);
  block.x_SYNC_MODE = block.x_CANsync_RUN = true;
  EXPECT_EQ(command(block, 1).mode, cansync_MODE_SETUP);
  const cansync_Command second = command(block, 2);
  EXPECT_EQ(second.mode, cansync_MODE_RUN);
  EXPECT_FALSE(second.force);
}

TEST_F(ModeMaCommands, RunIsGivenAgainForWhatPassesAndNotForWhatDoesNot) {
  constexpr std::chrono::milliseconds kAgain(500);
  const auto refused = [&] {
    return repeat_until([&] { cycle(block, now); }, [&] { return !block.error().empty(); });
  };
  daemon.refuse_modes(gateway_CAUSE_SLAVES_MISSING);
  block.x_CANsync_RUN = true;
  command(block, 1);
  ASSERT_TRUE(refused());
  EXPECT_EQ(block.cause(), RefusalCause::slaves_missing);
  daemon.refuse_modes(gateway_CAUSE_READ_ONLY);
  now += kAgain;
  command(block, 2);
  ASSERT_TRUE(
      repeat_until([&] { cycle(block, now); }, [&] { return block.cause() == RefusalCause::read_only; }));
  now += kAgain;
  for (int i = 0; i < 100; ++i) cycle(block, now);
  // A mode that goes another way comes after whatever the block had on its way.
  EXPECT_TRUE(client.mode(Mode::stop).wait().cause == RefusalCause::read_only);
  EXPECT_EQ(daemon.commands().size(), 3u) << "run twice, and the stop";
}

// "Inputs x_ASYNC_MODE0 and x_ASYNC_MODE1 are reserved and stay FALSE."
TEST_F(ModeMaCommands, ReservedInputsAreRefused) {
  block.x_ASYNC_MODE1 = true;
  cycle(block, now);
  EXPECT_NE(block.error().find("reserved"), std::string::npos);
  EXPECT_EQ(block.cause(), RefusalCause::field);
  block.x_ASYNC_MODE1 = false;
  block.x_SET_INIT_DATA = true;  // the configuration file has them
  set_state(cansync::State::waiting_for_start);
  cycle(block, now);
  block.x_SYNC_MODE = true;
  EXPECT_EQ(command(block, 1).mode, cansync_MODE_SETUP);
}

}  // namespace
}  // namespace cansync::client::function_blocks
