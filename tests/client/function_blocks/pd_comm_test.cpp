// CANsync_PD_COMM_MA and CANsync_PD_COMM_READ_MA, sections 4.19 and 4.20 of the application manual.
#include <algorithm>
#include <map>
#include <optional>
#include <utility>
#include <vector>

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

// "-128: automatic", "-1: no slave", "0 to 31": -2 means something to the daemon that the manual does not
// know.
TEST_F(PdComm, NumbersThatTheManualDoesNotKnowAreRefused) {
  for (SINT* input : {&block.si_RD_SL_NR1_RECEIVE, &block.si_RD_SL_NR2_RECEIVE, &block.si_MAX_SL_NR}) {
    const SINT was = std::exchange(*input, -2);
    block.call();
    EXPECT_NE(block.error().find("-2: out of range"), std::string::npos) << block.error();
    *input = was;
    block.call();
    EXPECT_EQ(block.error(), "");
  }
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

class PdCommActual : public CommandTest {};

// "in the last CANsync interval": what the daemon kept from before is not news.
TEST_F(PdCommActual, TheFirstCallTellsNoOldTelegram) {
  daemon.publish_actual(2, 4711, 600);
  PD_COMM_MA block(client);
  PD_COMM_READ_MA read(client);
  read.si_SL_NR = 2;
  block.x_COPY_TO_RD_ARRAY = true;
  std::vector<SINT> told;
  const auto call = [&] {
    block.call();
    read.call();
    if (block.si_RD_SL_NR1_RECEIVED != -128) told.push_back(block.si_RD_SL_NR1_RECEIVED);
  };
  // Another slave's telegrams come behind it.
  std::uint64_t interval = 1000;
  ASSERT_TRUE(repeat_until(
      [&] {
        daemon.publish_actual(3, 55, ++interval);
        call();
      },
      [&] { return block.a_RD_ARRAY[3][0] == 55; }));
  EXPECT_EQ(block.a_RD_ARRAY[2][0], 0);
  EXPECT_EQ(read.a_RD_VALUES[0], 0);
  daemon.publish_actual(2, 4712, ++interval);
  ASSERT_TRUE(repeat_until(call, [&] { return read.a_RD_VALUES[0] == 4712; }));
  ASSERT_TRUE(repeat_until(call, [&] { return block.a_RD_ARRAY[2][0] == 4712; }));
  EXPECT_EQ(std::count(told.begin(), told.end(), 2), 1);
}

// Interval numbers begin anew with a daemon.
TEST(PdCommRestart, TelegramsOfANewDaemonAreTold) {
  TwoPlaces places;
  std::optional<FakeDaemon> daemon(std::in_place, places.here);
  Client client = Client::connect(options_at(places.there));
  PD_COMM_MA block(client);
  std::uint64_t interval = 86'000'000;
  const auto step = [&] {
    daemon->publish_actual(3, 1, ++interval);
    block.call();
  };
  ASSERT_TRUE(repeat_until(step, [&] { return block.si_RD_SL_NR1_RECEIVED == 3; }));
  daemon.reset();
  daemon.emplace(places.here);
  for (int i = 0; i < 100; ++i) block.call();
  interval = 5;
  ASSERT_TRUE(repeat_until(step, [&] { return block.si_RD_SL_NR1_RECEIVED == 3; }));
}

// Settings that the daemon has lost with a restart are entered again, and no value is given before.
TEST(PdCommRestart, AfterANewStartOfTheDaemonSettingsAreEnteredAgainAndValuesWaitForTheProgram) {
  TwoPlaces places;
  std::optional<FakeDaemon> daemon(std::in_place, places.here);
  Client client = Client::connect(options_at(places.there));
  PD_CFG_MA mapping(client);
  mapping.a_WRC1 = {1, 1, 0, 2};
  mapping.a_HL_WRC1 = {false, true, false, false};
  PD_CFG_READ_MA actual(client);
  actual.si_SL_NR = 3;
  COMM_CONTROL_MA cursors(client);
  cursors.si_SL_NR_PAR = 2;
  cursors.x_EN_PAR = true;
  cursors.si_MAX_SL_NR = 3;
  PD_COMM_MA block(client);
  block.si_WRC1_SEND = 5;
  block.a_WR_VALUES_SEND[0] = 77;
  const auto call_all = [&] {
    mapping.call();
    actual.call();
    cursors.call();
    block.call();
  };
  const auto kinds = [&] {
    std::map<int, int> count;
    for (const cansync_Command& command : daemon->commands()) ++count[command.kind];
    return count;
  };
  ASSERT_TRUE(repeat_until(call_all, [&] { return !daemon->references().empty(); }));
  EXPECT_EQ(daemon->references_refused(), 0) << "given for the mapping of PD_CFG_MA alone";
  EXPECT_EQ(block.error(), "");
  const auto before = kinds();

  daemon.reset();
  daemon.emplace(places.here);
  ASSERT_TRUE(repeat_until(call_all, [&] { return kinds() == before; })) << "every setting once more";
  ASSERT_TRUE(repeat_until(call_all, [&] { return mapping.in_effect() && cursors.in_effect(); }));
  for (int i = 0; i < 100; ++i) call_all();
  EXPECT_TRUE(client.read(0, 1).ok());
  EXPECT_EQ(daemon->references().size(), 0u);
  EXPECT_NE(block.error().find("started anew"), std::string::npos) << block.error();

  block.si_WRC1_SEND = 0;
  call_all();
  EXPECT_EQ(block.error(), "");
  block.si_WRC1_SEND = 5;
  block.a_WR_VALUES_SEND[0] = 78;
  ASSERT_TRUE(repeat_until(call_all, [&] { return !daemon->references().empty(); }));
  const std::vector<std::int32_t> taken = daemon->references();
  EXPECT_EQ(taken, std::vector<std::int32_t>(taken.size(), 78));
  // Older values named the start before and were refused for it; none names the mapping before its own.
  const std::vector<std::int32_t> refused = daemon->refused_references();
  EXPECT_EQ(std::count(refused.begin(), refused.end(), 78), 0);
}

}  // namespace
}  // namespace cansync::client::function_blocks
