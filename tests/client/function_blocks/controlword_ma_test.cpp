// CANsync_CONTROLWORD_MA, sentence by sentence of section 4.7 of the application manual.
#include "block_rig.h"
#include "cansync/sim/drive_parameters.h"

namespace cansync::client::function_blocks {
namespace {

class ControlwordMa : public BlockTest {
 protected:
  CONTROLWORD_MA block{client};
};

// "acknowledges sending at output x_OK."
TEST_F(ControlwordMa, SendsAndAcknowledges) {
  block.si_SL_NR_CTRL = 2;
  block.w_CONTROLWORD = 0x0003;
  cycle(block, now);
  // "Output x_OK is FALSE if no control word message frame has been sent."
  EXPECT_FALSE(block.x_OK);
  block.x_EN = true;
  cycle(block, now);
  EXPECT_FALSE(block.x_OK);
  block.x_EN = false;
  ASSERT_TRUE(run_until(block, [&] { return block.x_OK; }));
  EXPECT_EQ(parameter(2, sim::parameter::control_word, false), 0x0003u);
  EXPECT_NE(parameter(1, sim::parameter::control_word, false), 0x0003u);
}

// "While x_EN stays TRUE, the system enters the control word for sending every time the FB is called."
TEST_F(ControlwordMa, TheNewestWordEnteredGoesOutLast) {
  block.si_SL_NR_CTRL = 1;
  block.x_EN = true;
  for (const WORD word : {WORD{0x0001}, WORD{0x0003}, WORD{0x0101}}) {
    block.w_CONTROLWORD = word;
    cycle(block, now);
  }
  block.x_EN = false;
  ASSERT_TRUE(run_until(block, [&] { return block.x_OK; }));
  EXPECT_EQ(parameter(1, sim::parameter::control_word, false), 0x0101u);
}

TEST_F(ControlwordMa, WrongSlaveIsNeverSent) {
  for (const SINT slave : {SINT{-1}, SINT{9}}) {
    block.si_SL_NR_CTRL = slave;
    send(block);
    EXPECT_FALSE(block.x_OK);
    EXPECT_EQ(block.error().rfind("client: slave ", 0), 0u) << block.error();
  }
}

}  // namespace
}  // namespace cansync::client::function_blocks
