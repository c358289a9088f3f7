// CANsync_PD_CFG_SL, CANsync_PD_CFG_READ_SL, CANsync_PD_COMM_SL and CANsync_PD_COMM_READ_SL,
// sections 4.17, 4.18, 4.21 and 4.22 of the application manual.
#include "client/src/cansync_slave/slave_side.h"
#include "slave_rig.h"

namespace cansync::client::function_blocks {
namespace {

class PdCfgSl : public SlaveBlockTest {};

// "Once": a mapping that is in force already is not given again.
TEST_F(PdCfgSl, AMappingThatDiffersIsGivenOnceAndThenInForce) {
  PD_CFG_SL block(connection);
  block.a_WRC1 = {0, 0, 1, 1};
  block.a_HL_WRC1 = {false, true, false, true};
  block.a_WRC2 = {4, 4, 5, 5};
  block.a_HL_WRC2 = {false, true, false, true};
  block.a_RDC1 = {0, 0, -1, -1};
  block.a_HL_RDC1 = {false, true, true, false};  // beside -1 it means nothing
  block.a_RDC2 = {7, -1, -1, -1};
  block.call();
  EXPECT_TRUE(block.in_effect()) << block.error();
  call_often(block);
  EXPECT_TRUE(daemon->commands.empty()) << "the daemon has it";
  block.a_RDC2 = {6, -1, -1, -1};
  block.call();
  EXPECT_FALSE(block.in_effect());
  ASSERT_TRUE(call_until(block, [&] { return block.in_effect(); })) << block.error();
  call_often(block);
  ASSERT_EQ(daemon->commands.size(), 1u);
  EXPECT_EQ(daemon->commands[0].kind, cansync_slave_SLAVE_COMMAND_MAPPING);
  EXPECT_EQ(daemon->commands[0].actual_mapping[4], 0x19);
  EXPECT_EQ(daemon->commands[0].reference_mapping[1], 0x03);
}

TEST_F(PdCfgSl, NumbersOfTheOtherTelegramAreNotGiven) {
  PD_CFG_SL block(connection);
  block.a_WRC1 = {4, -1, -1, -1};
  block.call();
  EXPECT_EQ(block.error(), "client: telegram 1 has a value number other than 0..3 and -1");
  block.a_WRC1[0] = 0;
  block.a_RDC2[0] = 3;
  block.call();
  EXPECT_EQ(block.error(), "client: telegram 2 has a value number other than 4..7 and -1");
  call_often(block);
  EXPECT_TRUE(daemon->commands.empty());
}

TEST_F(PdCfgSl, ARefusalIsToldAndNotAskedForAgainAndAnewAfterAStartOfTheDaemon) {
  daemon->refuses = "not now";
  PD_CFG_SL block(connection);
  block.a_WRC1 = {3, -1, -1, -1};
  ASSERT_TRUE(call_until(block, [&] {
    return !daemon->commands.empty() && !block.error().empty() && block.error().starts_with("daemon: ");
  })) << block.error();
  EXPECT_EQ(block.error(), "daemon: not now");
  EXPECT_EQ(block.cause(), RefusalCause::wrong_state);
  daemon.reset();
  daemon.emplace(places.here);
  ASSERT_TRUE(call_until(block, [&] { return block.in_effect(); })) << block.error();
  EXPECT_EQ(block.error(), "");
  EXPECT_EQ(daemon->commands.size(), 1u);
}

class PdCfgReadSl : public SlaveBlockTest {};

TEST_F(PdCfgReadSl, ListensToAnotherSlaveAndNotAnyMoreWithoutNumbers) {
  // What the daemon listens to comes after its identity.
  ASSERT_TRUE(repeat_until([&] { connection.side().look(); },
                           [&] { return connection.side().monitored(7).mapping != MappingBytes{}; }));
  PD_CFG_READ_SL block(connection);
  block.si_SL_NR = 7;
  block.a_RDC1 = {0, 0, 1, 1};
  block.a_HL_RDC1 = {false, true, false, true};
  ASSERT_TRUE(call_until(block, [&] { return block.in_effect(); })) << block.error();
  EXPECT_TRUE(daemon->commands.empty()) << "the daemon has it";
  block.a_RDC2[3] = 5;
  ASSERT_TRUE(call_until(block, [&] { return block.in_effect(); })) << block.error();
  ASSERT_EQ(daemon->commands.size(), 1u);
  EXPECT_EQ(daemon->commands[0].kind, cansync_slave_SLAVE_COMMAND_LISTEN);
  EXPECT_EQ(daemon->commands[0].other, 7);
  EXPECT_EQ(daemon->commands[0].actual_mapping[7], 0x15);
  block.a_RDC1 = block.a_RDC2 = {-1, -1, -1, -1};
  ASSERT_TRUE(call_until(block, [&] { return block.in_effect(); })) << block.error();
  EXPECT_EQ(daemon->commands[1].actual_mapping[7], 0);
  block.si_SL_NR = 32;
  block.call();
  EXPECT_EQ(block.error(), "client: slave 32: out of range; allowed 0..31");
  EXPECT_FALSE(block.in_effect());
}

class PdCommSl : public SlaveBlockTest {
 protected:
  std::size_t released(std::uint8_t telegram) {
    return static_cast<std::size_t>(std::count_if(daemon->releases.begin(), daemon->releases.end(),
                                                  [&](const auto& one) { return one.telegram == telegram; }));
  }
};

// a_WR_VALUES_RECEIVED: 0..3 only with WRC1, 4..7 only with WRC2; the receipts stand for one call.
TEST_F(PdCommSl, EachReferenceTelegramFillsItsHalf) {
  PD_COMM_SL block(connection);
  block.call();
  EXPECT_EQ(block.si_WRC1_RECEIVED, 0);
  daemon->references(1, 100, 9);
  ASSERT_TRUE(call_until(block, [&] { return block.si_WRC1_RECEIVED == 1; }));
  EXPECT_EQ(block.si_WRC2_RECEIVED, 0);
  EXPECT_EQ(block.a_WR_VALUES_RECEIVED, (DINT_8_BMARRAY{100, 101, 102, 103}));
  block.call();
  EXPECT_EQ(block.si_WRC1_RECEIVED, 0);
  daemon->references(2, 200, 9);
  ASSERT_TRUE(call_until(block, [&] { return block.si_WRC2_RECEIVED == 2; }));
  EXPECT_EQ(block.si_WRC1_RECEIVED, 0) << "the interval of WRC1 is the one known";
  EXPECT_EQ(block.a_WR_VALUES_RECEIVED, (DINT_8_BMARRAY{100, 101, 102, 103, 200, 201, 202, 203}));
  // A reader that is slow gets the newest sample alone: the interval tells that WRC1 came too.
  daemon->references(1, 300, 10);
  daemon->references(2, 400, 10);
  ASSERT_TRUE(call_until(block, [&] { return block.a_WR_VALUES_RECEIVED[7] == 403; }));
  EXPECT_EQ(block.a_WR_VALUES_RECEIVED[0], 300);
}

// Without SYNC there are no intervals to tell telegrams apart by.
TEST_F(PdCommSl, TelegramsAreReceivedWithoutIntervalsToo) {
  PD_COMM_SL block(connection);
  PD_COMM_READ_SL read(connection);
  read.si_SL_NR = 7;
  daemon->monitored(7, 1, 60, 0);
  for (const std::uint32_t first : {100u, 200u, 200u}) {
    daemon->references(1, first, 0);
    ASSERT_TRUE(call_until(block, [&] { return block.si_WRC1_RECEIVED == 1; })) << first;
    EXPECT_EQ(block.a_WR_VALUES_RECEIVED[3], static_cast<DINT>(first) + 3);
    EXPECT_EQ(block.si_WRC2_RECEIVED, 0);
    daemon->references(2, first, 0);
    ASSERT_TRUE(call_until(block, [&] { return block.si_WRC2_RECEIVED == 2; })) << first;
    EXPECT_EQ(block.si_WRC1_RECEIVED, 0);
    block.call();
    EXPECT_EQ(block.si_WRC1_RECEIVED, 0);
    EXPECT_EQ(block.si_WRC2_RECEIVED, 0);
  }
  read.call();
  daemon->monitored(7, 1, 70, 0);
  ASSERT_TRUE(call_until(read, [&] { return read.si_RD_SL_NR1_RECEIVED == 1; }));
  EXPECT_EQ(read.a_RD_VALUES[0], 70);
}

// "A value of 5 indicates that actual values 0 to 3 are valid, whereas any other value indicates that actual
// values 0 to 3 are not valid."
TEST_F(PdCommSl, FiveReleasesATelegramOnceForEachCall) {
  PD_COMM_SL block(connection);
  block.a_RD_VALUES_SEND = {1, -2, 3, 4, 5, 6, 7, 8};
  block.si_RDC1_SEND = 4;
  block.si_RDC2_SEND = 5;
  ASSERT_TRUE(call_until(block, [&] { return !daemon->releases.empty(); }));
  EXPECT_EQ(released(1), 0u);
  const cansync_slave_ActualRelease first = daemon->releases[0];
  EXPECT_EQ(first.telegram, 2);
  EXPECT_EQ(std::to_array(first.raw), (std::array<std::uint32_t, 4>{5, 6, 7, 8}));
  EXPECT_EQ(first.valid, 0x0F);
  EXPECT_EQ(first.wait_intervals, 2u);
  block.si_RDC2_SEND = 0;
  block.si_RDC1_SEND = 5;
  block.u_WAIT_INTERVALS = 9;
  ASSERT_TRUE(call_until(block, [&] { return released(1) != 0; }));
  EXPECT_EQ(daemon->releases.back().wait_intervals, 9u);
  EXPECT_EQ(daemon->releases.back().raw[1], 0xFFFFFFFEu);
  EXPECT_EQ(block.error(), "");
}

// After a restart of the daemon nothing goes out by itself.
TEST_F(PdCommSl, ADaemonStartedAnewGetsNothingBeforeTheInputsWereLetGo) {
  PD_COMM_SL block(connection);
  block.si_RDC1_SEND = 5;
  ASSERT_TRUE(call_until(block, [&] { return released(1) != 0; }));
  daemon.reset();
  daemon.emplace(places.here);
  ASSERT_TRUE(call_until(block, [&] { return block.error().find("started anew") != std::string::npos; }));
  call_often(block);
  EXPECT_EQ(released(1), 0u);
  block.si_RDC1_SEND = 0;
  block.call();
  EXPECT_EQ(block.error(), "");
  block.si_RDC1_SEND = 5;
  ASSERT_TRUE(call_until(block, [&] { return released(1) != 0; }));
}

// "At input x_COPY_TO_RD_ARRAY, the system indicates with TRUE that the monitored actual values are entered
// in the two-dimensional field at a_RD_ARRAY."
TEST_F(PdCommSl, ActualValuesOfOtherSlavesGoToTheArrayWhenThatIsWanted) {
  PD_CFG_READ_SL known(connection);
  known.si_SL_NR = 7;
  known.a_RDC1 = {0, 0, 1, 1};
  known.a_HL_RDC1 = {false, true, false, true};
  ASSERT_TRUE(call_until(known, [&] { return known.in_effect(); }));
  PD_COMM_SL block(connection);
  PD_COMM_READ_SL read(connection);
  read.si_SL_NR = 7;
  EXPECT_EQ(block.si_RD_SL_NR1_RECEIVED, -128);
  daemon->monitored(7, 1, 70, 3);
  ASSERT_TRUE(call_until(block, [&] { return block.si_RD_SL_NR1_RECEIVED == 7; }));
  EXPECT_EQ(block.si_RD_SL_NR2_RECEIVED, -128);
  EXPECT_EQ(block.a_RD_ARRAY[7][0], 0) << "x_COPY_TO_RD_ARRAY is FALSE";
  block.x_COPY_TO_RD_ARRAY = true;
  daemon->monitored(7, 2, 74, 4);
  ASSERT_TRUE(call_until(block, [&] { return block.si_RD_SL_NR2_RECEIVED == 7; }));
  EXPECT_EQ(block.si_RD_SL_NR1_RECEIVED, -128);
  EXPECT_EQ(block.a_RD_ARRAY[7][4], 74);
  EXPECT_EQ(block.a_RD_ARRAY[7][0], 0) << "it changes with its telegram only";
  block.call();
  EXPECT_EQ(block.si_RD_SL_NR2_RECEIVED, -128);
  // PD_COMM_READ_SL: both have come since its last call.
  read.call();
  EXPECT_EQ(read.si_RD_SL_NR1_RECEIVED, 1);
  EXPECT_EQ(read.si_RD_SL_NR2_RECEIVED, 2);
  EXPECT_EQ(read.a_RD_VALUES, (DINT_8_BMARRAY{70, 71, 72, 73, 74, 75, 76, 77}));
  read.call();
  EXPECT_EQ(read.si_RD_SL_NR1_RECEIVED, 0);
  EXPECT_EQ(read.si_RD_SL_NR2_RECEIVED, 0);
  read.si_SL_NR = 32;
  read.call();
  EXPECT_EQ(read.si_RD_SL_NR1_RECEIVED, 0);
}

}  // namespace
}  // namespace cansync::client::function_blocks
