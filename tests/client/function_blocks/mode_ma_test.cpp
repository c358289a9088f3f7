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
  block.x_SYNC_MODE = true;
  ASSERT_TRUE(run_until(block, [&] { return block.x_PREPARE_ACTIV; }));
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
  MODE_MA block{client};
};

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
  cycle(block, now);
  block.x_SYNC_MODE = true;
  EXPECT_EQ(command(block, 1).mode, cansync_MODE_SETUP);
}

}  // namespace
}  // namespace cansync::client::function_blocks
