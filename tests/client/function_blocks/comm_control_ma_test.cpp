// CANsync_COMM_CONTROL_MA, sentence by sentence of section 4.6 of the application manual.
#include "block_rig.h"
#include "cansync/sim/drive_parameters.h"

namespace cansync::client::function_blocks {
namespace {

class CommControlMaCommands : public CommandTest {
 protected:
  COMM_CONTROL_MA block{client};
};

// "The system only applies the setting ... if x_EN_CTRL = TRUE. If x_EN_CTRL = FALSE, the system does not
// change this part of the command channel configuration."
TEST_F(CommControlMaCommands, OnlyEnabledSettingsAreChanged) {
  block.si_SL_NR_CTRL = 3;
  block.si_SL_NR_PAR = 2;
  block.x_EN_PAR = true;
  const cansync_Command first = command(block, 1);
  EXPECT_EQ(first.kind, cansync_COMMAND_CHANNEL_CURSORS);
  EXPECT_EQ(first.cursor_control_word, kUnchanged);
  EXPECT_EQ(first.cursor_parameter, 2);
  EXPECT_EQ(first.cursor_transfer, kUnchanged);
  ASSERT_TRUE(repeat_until([&] { block.call(); }, [&] { return block.in_effect(); }));
  // "The default setting is ... -128, i.e. automatic incrementing until si_MAX_SL_NR."
  block.x_EN_UDL = block.x_EN_CTRL = true;
  block.si_SL_NR_UDL = -128;
  const cansync_Command second = command(block, 2);
  EXPECT_EQ(second.cursor_control_word, 3);
  EXPECT_EQ(second.cursor_transfer, kAutomatic);
}

// "If si_MAX_SL_NR = -1, the value remains unchanged". "The default setting is si_MAX_SL_NR = -1".
TEST_F(CommControlMaCommands, MaximumSlaveIsSentUnlessMinusOne) {
  (void)command(block, 1);
  block.si_MAX_SL_NR = 3;
  const cansync_Command polling = command(block, 2);
  EXPECT_EQ(polling.kind, cansync_COMMAND_POLLING);
  EXPECT_EQ(polling.maximum_slave, 3);
  EXPECT_EQ(polling.polling_one, kUnchanged);
  ASSERT_TRUE(repeat_until([&] { block.call(); }, [&] { return block.in_effect(); }));
  for (int i = 0; i < 100; ++i) block.call();
  EXPECT_EQ(daemon.commands().size(), 2u);  // what does not change is not sent again
  block.si_MAX_SL_NR = -5;
  block.call();
  EXPECT_FALSE(block.in_effect());
  block.si_MAX_SL_NR = -1;
  block.call();
  EXPECT_TRUE(block.in_effect()) << "what was in effect before the wrong one";
  EXPECT_EQ(daemon.commands().size(), 2u);
}

TEST_F(CommControlMaCommands, WrongNumbersAreRefused) {
  block.si_SL_NR_PAR = -1;
  block.x_EN_PAR = true;
  block.call();
  EXPECT_EQ(block.error(), "client: slave -1: out of range; allowed 0..31, -128 automatic");
  EXPECT_FALSE(block.in_effect());
  block.si_SL_NR_PAR = 9;
  ASSERT_TRUE(repeat_until([&] { block.call(); }, [&] { return block.error().rfind("daemon: ", 0) == 0; }));
  EXPECT_NE(block.error().find("cursor_parameter 9: not configured"), std::string::npos) << block.error();
  block.si_MAX_SL_NR = -5;
  block.call();
  EXPECT_EQ(daemon.commands().size(), 0u);
  block.si_SL_NR_PAR = 1;
  const auto names_it = [&] {
    return SettingSlot::missing(client).find("si_MAX_SL_NR -5") != std::string::npos;
  };
  ASSERT_TRUE(repeat_until([&] { block.call(); }, names_it)) << SettingSlot::missing(client);
  block.si_MAX_SL_NR = -1;
  ASSERT_TRUE(repeat_until([&] { block.call(); }, [&] { return block.in_effect(); })) << block.error();
  EXPECT_EQ(SettingSlot::missing(client), "");
}

class CommControlMa : public BlockTest {};

// A slave "for which the system is to carry out polling": jobs of the others are not served.
TEST_F(CommControlMa, JobsOfOtherSlavesWait) {
  COMM_CONTROL_MA block(client);
  block.si_SL_NR_PAR = 1;
  block.x_EN_PAR = true;
  ASSERT_TRUE(run_until(block, [&] { return block.in_effect(); })) << block.error();
  PAR_READ_MA other(client);
  other.si_SL_NR = 2;
  other.u_PAR_NR = sim::parameter::slave_number;
  other.x_EN = true;
  cycle(other, now);
  EXPECT_EQ(parameter(1, sim::parameter::slave_number, false), 1u);
  EXPECT_TRUE(other.x_BUSY);
  block.si_SL_NR_PAR = -128;
  ASSERT_TRUE(run_until(block, [&] { return block.in_effect(); })) << block.error();
  ASSERT_TRUE(run_until(other, [&] { return !other.x_BUSY; }));
  EXPECT_TRUE(other.x_OK) << other.error();
}

}  // namespace
}  // namespace cansync::client::function_blocks
