// CANsync_PAR_READ_MA, sentence by sentence of section 4.12 of the application manual.
#include "block_rig.h"
#include "cansync/sim/drive_parameters.h"

namespace cansync::client::function_blocks {
namespace {

class ParReadMa : public BlockTest {
 protected:
  PAR_READ_MA block{client};
};

// "The default setting for t_TIME is 3 s."
TEST_F(ParReadMa, MonitoringTimeIsThreeSecondsByDefault) {
  EXPECT_EQ(block.t_TIME, std::chrono::seconds(3));
}

// "Communication is started by means of x_EN = TRUE." "x_BUSY indicates by TRUE that communication is
// active."
TEST_F(ParReadMa, EnableStartsAndBusyShowsIt) {
  block.u_PAR_NR = sim::parameter::slave_number;
  block.si_SL_NR = 2;
  cycle(block, now);
  EXPECT_FALSE(block.x_BUSY);
  block.x_EN = true;
  cycle(block, now);
  EXPECT_TRUE(block.x_BUSY);
  EXPECT_FALSE(block.x_OK);
  cycle(block, now);
  EXPECT_TRUE(block.x_BUSY);
  ASSERT_TRUE(run_until(block, [&] { return !block.x_BUSY; }));
  // "x_OK is set to TRUE if the read parameter job was executed correctly." "ud_PAR_VALUE": the value read.
  EXPECT_TRUE(block.x_OK);
  EXPECT_FALSE(block.x_ERR);
  EXPECT_EQ(block.ud_PAR_VALUE, 2u);
  EXPECT_FALSE(block.x_PAR_FORMAT_READ);
  // Nothing starts again while x_EN stays.
  cycle(block, now);
  EXPECT_FALSE(block.x_BUSY);
  EXPECT_TRUE(block.x_OK);
}

// "x_PAR_FORMAT = TRUE means doubleword format."
TEST_F(ParReadMa, ReadsADoublewordAndThenAnotherParameter) {
  block.si_SL_NR = 1;
  block.u_PAR_NR = sim::parameter::serial_number;
  block.x_PAR_FORMAT = true;
  do_job(block);
  EXPECT_TRUE(block.x_OK) << block.error();
  EXPECT_EQ(block.ud_PAR_VALUE, 1001u);
  EXPECT_TRUE(block.x_PAR_FORMAT_READ);
  block.u_PAR_NR = sim::parameter::firmware_version;
  do_job(block);
  EXPECT_TRUE(block.x_OK);
  EXPECT_EQ(block.ud_PAR_VALUE, 0x10000u);
}

// b_ERR bit 2: "Doubleword format (TRUE) was expected", bit 3: "Word format (FALSE) was expected".
TEST_F(ParReadMa, WrongFormatIsBitTwoOrThree) {
  block.u_PAR_NR = sim::parameter::serial_number;
  do_job(block);
  EXPECT_TRUE(block.x_ERR);
  EXPECT_FALSE(block.x_OK);
  EXPECT_EQ(block.b_ERR, 0x04);
  block.x_RESET = true;
  cycle(block, now);
  block.x_RESET = false;
  block.u_PAR_NR = sim::parameter::slave_number;
  block.x_PAR_FORMAT = true;
  do_job(block);
  EXPECT_EQ(block.b_ERR, 0x08);
}

// b_ERR bit 0: "Communications error, error number is in i_ERR".
TEST_F(ParReadMa, TheSlavesErrorNumberIsInIErr) {
  block.u_PAR_NR = sim::parameter::not_available;
  do_job(block);
  EXPECT_TRUE(block.x_ERR);
  EXPECT_EQ(block.b_ERR, 0x01);
  EXPECT_EQ(static_cast<std::uint16_t>(block.i_ERR), 0xFFFA);
  EXPECT_EQ(block.error().rfind("slave: ", 0), 0u) << block.error();
}

TEST_F(ParReadMa, WhatTheDaemonRefusesIsBitZeroWithoutANumber) {
  block.u_PAR_NR = 5000;
  do_job(block);
  EXPECT_EQ(block.b_ERR, 0x01);
  EXPECT_EQ(block.i_ERR, 0);
  EXPECT_EQ(block.error(), "daemon: number 5000: out of range; allowed 0..4095");
  EXPECT_EQ(block.cause(), RefusalCause::field);
}

// b_ERR bit 4: "Invalid slave number of the CANsync slaves on the CANsync bus".
TEST_F(ParReadMa, WrongSlaveIsBitFour) {
  for (const int number : {-1, 4, 31, 32, -128}) {
    block.si_SL_NR = static_cast<SINT>(number);
    block.x_EN = true;
    cycle(block, now);
    EXPECT_FALSE(block.x_BUSY) << number;
    EXPECT_TRUE(block.x_ERR) << number;
    EXPECT_EQ(block.b_ERR, 0x10) << number;
    block.x_RESET = true;
    cycle(block, now);
    block.x_RESET = false;
    EXPECT_FALSE(block.x_ERR);
  }
}

// "If the read parameter job is not completed within the monitoring time, the system sets bit 1".
TEST_F(ParReadMa, TimeoutOfTheSlaveIsBitOne) {
  rig.line().drive(0).answer_busy(sim::DriveParameters::kEndless);
  block.u_PAR_NR = sim::parameter::slave_number;
  block.t_TIME = std::chrono::milliseconds(50);
  block.x_EN = true;
  cycle(block, now);
  ASSERT_TRUE(run_until(block, [&] { return !block.x_BUSY; }));
  EXPECT_EQ(block.b_ERR, 0x02);
  EXPECT_TRUE(block.x_ERR);
  EXPECT_FALSE(block.x_OK);
}

TEST_F(ParReadMa, TimeoutOfTheDaemonIsBitOneToo) {
  block.x_EN = true;
  block.t_TIME = std::chrono::seconds(2);
  cycle(block, now);
  cycle(block, now + std::chrono::milliseconds(1999));
  EXPECT_TRUE(block.x_BUSY);
  cycle(block, now + std::chrono::milliseconds(2000));
  EXPECT_FALSE(block.x_BUSY);
  EXPECT_EQ(block.b_ERR, 0x02);
}

// "it is assumed that communication was cancelled deliberately and you must reset the FB (x_RESET = TRUE)."
TEST_F(ParReadMa, EnableTakenAwayCancelsAndNeedsAReset) {
  block.u_PAR_NR = sim::parameter::slave_number;
  block.x_EN = true;
  cycle(block, now);
  block.x_EN = false;
  cycle(block, now);
  EXPECT_FALSE(block.x_BUSY);
  EXPECT_FALSE(block.x_OK);
  block.x_EN = true;
  cycle(block, now);
  EXPECT_FALSE(block.x_BUSY);
  block.x_RESET = true;
  cycle(block, now);
  EXPECT_FALSE(block.x_BUSY);
  // "After this, you must set x_RESET back to FALSE."
  block.x_RESET = false;
  block.si_SL_NR = 3;
  cycle(block, now);
  EXPECT_TRUE(block.x_BUSY);
  ASSERT_TRUE(run_until(block, [&] { return !block.x_BUSY; }));
  EXPECT_TRUE(block.x_OK);
  EXPECT_EQ(block.ud_PAR_VALUE, 3u);
}

// "This is necessary after ... an error message".
TEST_F(ParReadMa, AfterAnErrorNothingStartsBeforeAReset) {
  block.u_PAR_NR = sim::parameter::not_available;
  do_job(block);
  ASSERT_TRUE(block.x_ERR);
  block.u_PAR_NR = sim::parameter::slave_number;
  block.x_EN = true;
  cycle(block, now);
  EXPECT_FALSE(block.x_BUSY);
  EXPECT_TRUE(block.x_ERR);
  block.x_RESET = true;
  cycle(block, now);
  EXPECT_FALSE(block.x_ERR);
  EXPECT_EQ(block.b_ERR, 0);
  EXPECT_EQ(block.i_ERR, 0);
  EXPECT_EQ(block.error(), "");
}

}  // namespace
}  // namespace cansync::client::function_blocks
