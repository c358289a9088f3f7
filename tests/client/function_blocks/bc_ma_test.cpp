// CANsync_BC_MA0, BC_MA1 and BC_MA2, sentence by sentence of sections 4.2 to 4.4 of the application manual.
#include "block_rig.h"
#include "cansync/sim/drive_parameters.h"

namespace cansync::client::function_blocks {
namespace {

class BcMa : public BlockTest {};

// "bit n of d_SL_MASK": the slaves that get it. "x_OK ... the last broadcast message frame has been sent."
TEST_F(BcMa, ReachesTheSlavesOfTheMaskAlone) {
  BC_MA1 block(client);
  block.us_BC_CMD_NR = 200;
  block.si_BC_BYTE = -2;
  block.i_BC_WORD = -3;
  block.d_SL_MASK = 0b0101;
  cycle(block, now);
  EXPECT_FALSE(block.x_OK);
  block.x_EN = true;
  cycle(block, now);
  EXPECT_FALSE(block.x_OK);
  block.x_EN = false;
  ASSERT_TRUE(run_until(block, [&] { return block.x_OK; }));
  for (const SINT slave : {SINT{0}, SINT{1}, SINT{2}, SINT{3}})
    EXPECT_EQ(parameter(slave, sim::parameter::action_count, true), slave % 2 == 0 ? 1u : 0u) << int{slave};
  EXPECT_EQ(parameter(2, sim::parameter::last_action, true), 0xC8FEFFFDu);
}

// "If you want to address all the CANsync slaves, you must set d_SL_MASK = 16#FFFFFFFF."
TEST_F(BcMa, AllOnesAreEveryConfiguredSlave) {
  BC_MA0 block(client);
  block.us_BC_CMD_NR = 1;  // "1: control word; i_BC_WORD: control word"
  block.i_BC_WORD = 0x0003;
  block.d_SL_MASK = 0xFFFFFFFF;
  send(block);
  EXPECT_TRUE(block.x_OK) << block.error();
  for (const SINT slave : {SINT{0}, SINT{1}, SINT{2}, SINT{3}})
    EXPECT_EQ(parameter(slave, sim::parameter::control_word, false), 3u);
}

// "2 to 127: Reserved".
TEST_F(BcMa, ReservedCommandsAndStrangeSlavesAreNotSent) {
  BC_MA2 block(client);
  block.us_BC_CMD_NR = 5;
  block.d_SL_MASK = 1;
  send(block);
  EXPECT_FALSE(block.x_OK);
  EXPECT_EQ(block.error().rfind("daemon: action 5: reserved", 0), 0u) << block.error();
  block.us_BC_CMD_NR = 200;
  block.d_SL_MASK = 1u << 20;
  send(block);
  EXPECT_FALSE(block.x_OK);
  EXPECT_NE(block.error().find("slaves 20 are not configured"), std::string::npos) << block.error();
}

class BcMaCommands : public CommandTest {};

// "transmission ranges 0 to 2".
TEST_F(BcMaCommands, EachBlockHasItsOwnRange) {
  BC_MA0 zero(client);
  BC_MA1 one(client);
  BC_MA2 two(client);
  for (BroadcastBlock* block : {static_cast<BroadcastBlock*>(&zero), static_cast<BroadcastBlock*>(&one),
                                static_cast<BroadcastBlock*>(&two)}) {
    block->us_BC_CMD_NR = 128;
    block->d_SL_MASK = 1;
    block->x_EN = true;
    block->call();
    block->x_EN = false;
  }
  (void)command(zero, 3);
  std::uint32_t expected = 0;
  for (const cansync_Command& taken : daemon.commands()) EXPECT_EQ(taken.priority, expected++);
}

// "While x_EN is set to TRUE, the system enters the broadcast command ... every time the FB is called."
TEST_F(BcMaCommands, IsEnteredAgainInEveryCall) {
  BC_MA2 block(client);
  block.us_BC_CMD_NR = 128;
  block.d_SL_MASK = 1;
  block.x_EN = true;
  EXPECT_EQ(command(block, 5).action, 128u);
}

// One that is not answered stays alone on its way: calls neither wait nor pile up.
TEST_F(BcMaCommands, NothingPilesUpBehindOneThatIsNotAnswered) {
  BC_MA2 block(client);
  block.us_BC_CMD_NR = FakeDaemon::kSilentAction;
  block.d_SL_MASK = 1;
  block.x_EN = true;
  (void)command(block, 1);
  for (int i = 0; i < 1000; ++i) block.call();
  EXPECT_FALSE(block.x_OK);
  EXPECT_EQ(daemon.commands().size(), 1u);
}

}  // namespace
}  // namespace cansync::client::function_blocks
