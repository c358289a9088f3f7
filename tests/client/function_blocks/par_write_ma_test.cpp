// CANsync_PAR_WRITE_MA, sentence by sentence of section 4.14 of the application manual.
#include "block_rig.h"
#include "cansync/sim/drive_parameters.h"

namespace cansync::client::function_blocks {
namespace {

class ParWriteMa : public BlockTest {
 protected:
  ParWriteMa() {
    block.si_SL_NR = 1;
    block.u_PAR_NR = sim::parameter::first_plain_word;
  }
  void reset() {
    block.x_RESET = true;
    cycle(block, now);
    block.x_RESET = false;
  }
  PAR_WRITE_MA block{client};
};

// "transfers ... a write parameter job to the CANsync slave with slave number si_SL_NR."
TEST_F(ParWriteMa, WritesAWordAndADoubleword) {
  EXPECT_EQ(block.t_TIME, std::chrono::seconds(3));
  block.ud_PAR_VALUE = 0xBEEF;
  block.x_EN = true;
  cycle(block, now);
  EXPECT_TRUE(block.x_BUSY);
  ASSERT_TRUE(run_until(block, [&] { return !block.x_BUSY; }));
  EXPECT_TRUE(block.x_OK) << block.error();
  block.x_EN = false;
  cycle(block, now);
  EXPECT_EQ(parameter(1, sim::parameter::first_plain_word, false), 0xBEEFu);
  EXPECT_EQ(parameter(2, sim::parameter::first_plain_word, false), 0u);

  block.u_PAR_NR = sim::parameter::user_doubleword;
  block.x_PAR_FORMAT = true;
  block.ud_PAR_VALUE = 0xDEADBEEF;
  do_job(block);
  EXPECT_TRUE(block.x_OK) << block.error();
  EXPECT_EQ(parameter(1, sim::parameter::user_doubleword, true), 0xDEADBEEFu);
}

// "If the CANsync slave reports an error number, the system outputs an error number at output i_ERR."
TEST_F(ParWriteMa, TheSlavesErrorsAreBitZero) {
  block.u_PAR_NR = sim::parameter::lag;
  block.ud_PAR_VALUE = 10001;
  do_job(block);
  EXPECT_TRUE(block.x_ERR);
  EXPECT_FALSE(block.x_OK);
  EXPECT_EQ(block.b_ERR, 0x01);
  EXPECT_EQ(static_cast<std::uint16_t>(block.i_ERR), 0xFFFD);
  // Bits 2 and 3 are reserved here: a wrong format is the slave's error number.
  reset();
  block.x_PAR_FORMAT = true;
  block.ud_PAR_VALUE = 1;
  do_job(block);
  EXPECT_EQ(block.b_ERR, 0x01);
  EXPECT_EQ(static_cast<std::uint16_t>(block.i_ERR), 0xFFF9);
}

TEST_F(ParWriteMa, AValueTooWideForAWordIsRefusedNotCut) {
  block.ud_PAR_VALUE = 0x12345;
  do_job(block);
  EXPECT_EQ(block.b_ERR, 0x01);
  EXPECT_NE(block.error().find("daemon: value 74565: too wide for a word"), std::string::npos)
      << block.error();
  EXPECT_EQ(parameter(1, sim::parameter::first_plain_word, false), 0u);
}

// b_ERR bit 4: "Invalid slave number of the CANsync slaves on the CANsync bus".
TEST_F(ParWriteMa, WrongSlaveIsBitFour) {
  block.si_SL_NR = 7;
  do_job(block);
  EXPECT_EQ(block.b_ERR, 0x10);
  EXPECT_TRUE(block.x_ERR);
}

// "If the write parameter job is not completed within the monitoring time, the system sets bit 1".
TEST_F(ParWriteMa, TimeoutIsBitOne) {
  rig.line().drive(1).answer_busy(sim::DriveParameters::kEndless);
  block.t_TIME = std::chrono::milliseconds(50);
  do_job(block);
  EXPECT_EQ(block.b_ERR, 0x02);
  reset();
  block.x_EN = true;
  cycle(block, now);
  cycle(block, now + block.t_TIME);
  EXPECT_EQ(block.b_ERR, 0x02);
  EXPECT_NE(block.error().find("whether the slave took the value is not known"), std::string::npos);
}

// x_EN = FALSE while busy: "cancelled deliberately and you must reset the FB".
TEST_F(ParWriteMa, EnableTakenAwayCancelsAndNeedsAReset) {
  block.x_EN = true;
  cycle(block, now);
  block.x_EN = false;
  cycle(block, now);
  EXPECT_FALSE(block.x_BUSY);
  block.x_EN = true;
  cycle(block, now);
  EXPECT_FALSE(block.x_BUSY);
  reset();
  block.ud_PAR_VALUE = 5;
  do_job(block);
  EXPECT_TRUE(block.x_OK);
  EXPECT_EQ(parameter(1, sim::parameter::first_plain_word, false), 5u);
}

}  // namespace
}  // namespace cansync::client::function_blocks
