// CANsync_PD_COMM_MA and CANsync_PD_COMM_READ_MA, sections 4.19 and 4.20 of the application manual.
#include "block_rig.h"

namespace cansync::client::function_blocks {
namespace {

class PdComm : public BlockTest {
 protected:
  PD_COMM_MA block{client};
};

// "A value of 5 indicates that reference values 0 to 3 are valid, whereas any other value indicates that
// [they] are not valid."
TEST_F(PdComm, FiveReleasesTheValuesOfATelegram) {
  block.a_WR_VALUES_SEND = {1000, 1, 2, 3, 4321, 5, 6, 7};
  block.si_WRC1_SEND = 4;
  block.si_WRC2_SEND = 5;
  // While time is held the line may be looked at: what slave 2 got.
  const cansync::Values& got = rig.line().drive(2).slave().references();
  ASSERT_TRUE(run_until(block, [&] { return got[4] == 4321; }));
  EXPECT_EQ(block.error(), "");
  EXPECT_EQ(got[0], 0u);
  block.si_WRC1_SEND = 5;
  ASSERT_TRUE(run_until(block, [&] { return got[0] == 1000; }));
}

// "the system indicates with TRUE that the received actual values are entered in ... a_RD_ARRAY." "If the
// system indicates FALSE ... or [it] is not assigned, the received actual values are not entered".
TEST_F(PdComm, ActualValuesAreEnteredWhenTheyAreToBe) {
  block.si_WRC1_SEND = block.si_WRC2_SEND = 5;
  ASSERT_TRUE(run_until(block, [&] { return block.si_RD_SL_NR2_RECEIVED >= 0; }));
  for (const DINT_16_BMARRAY& slave : block.a_RD_ARRAY) EXPECT_EQ(slave, DINT_16_BMARRAY{});
  block.x_COPY_TO_RD_ARRAY = true;
  // Value 5 of a simulated drive is its status word, not 0 when it runs.
  ASSERT_TRUE(run_until(block, [&] {
    return block.a_RD_ARRAY[0][5] != 0 && block.a_RD_ARRAY[1][5] != 0 && block.a_RD_ARRAY[2][5] != 0 &&
           block.a_RD_ARRAY[3][5] != 0;
  }));
  EXPECT_EQ(block.a_RD_ARRAY[4], DINT_16_BMARRAY{});
}

// "If no actual value message frame 1 was received ..., the system displays -128 at si_RD_SL_NR1_RECEIVED."
TEST_F(PdComm, ShowsWhoseTelegramCameAndMinus128WhenNoneDid) {
  // Explicit and automatic specification may be mixed.
  block.si_RD_SL_NR1_RECEIVE = 3;
  block.si_WRC1_SEND = 5;
  ASSERT_TRUE(run_until(block, [&] { return block.si_RD_SL_NR1_RECEIVED == 3; }));
  EXPECT_EQ(block.si_RD_SL_NR2_RECEIVED, -128);  // telegram 2 was not released, so nobody was asked
  block.si_WRC1_SEND = 0;
  // The line stands still: what was on its way arrives, then nothing more.
  ASSERT_TRUE(repeat_until([&] { block.call(); }, [&] { return block.si_RD_SL_NR1_RECEIVED == -128; }));
}

TEST_F(PdComm, AWrongSlaveIsTheDaemonsRefusal) {
  block.si_RD_SL_NR1_RECEIVE = 9;
  ASSERT_TRUE(repeat_until([&] { block.call(); }, [&] { return !block.error().empty(); }));
  EXPECT_NE(block.error().find("daemon: polling_one 9: not configured"), std::string::npos) << block.error();
}

// 4.20: "indicates with 1 whether actual value message frame 1 was received", "with 2 ... frame 2". "The new
// actual values 0 to 3 are only output at a_RD_VALUES when actual value message frame 1 was received."
TEST_F(PdComm, ReadMaShowsOneSlave) {
  PD_COMM_READ_MA read(client);
  read.si_SL_NR = 1;
  read.call();
  EXPECT_EQ(read.si_RD_SL_NR1_RECEIVED, 0);
  EXPECT_EQ(read.si_RD_SL_NR2_RECEIVED, 0);
  block.si_WRC2_SEND = 5;
  bool first_came = false;
  ASSERT_TRUE(run_until(block, [&] {
    read.call();
    first_came |= read.si_RD_SL_NR1_RECEIVED != 0;
    return read.a_RD_VALUES[5] != 0;
  }));
  EXPECT_EQ(read.si_RD_SL_NR2_RECEIVED, 2);
  EXPECT_FALSE(first_came);
  EXPECT_EQ(read.a_RD_VALUES[0], 0);
  block.si_WRC1_SEND = 5;
  ASSERT_TRUE(run_until(block, [&] {
    read.call();
    return read.si_RD_SL_NR1_RECEIVED == 1;
  }));
  read.si_SL_NR = 31;
  read.call();
  EXPECT_EQ(read.si_RD_SL_NR1_RECEIVED, 0);
  read.si_SL_NR = -1;
  read.call();
  EXPECT_EQ(read.si_RD_SL_NR2_RECEIVED, 0);
}

}  // namespace
}  // namespace cansync::client::function_blocks
