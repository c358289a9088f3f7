#include "cli/cansync/wait_states.h"

#include <gtest/gtest.h>

#include <cstdio>

#include "cli/text/values.h"

namespace cansync::cli {
namespace {

client::SlaveStatus slave(unsigned number, const char* state, bool responds, bool synchronized) {
  client::SlaveStatus status{};
  status.slave = static_cast<std::uint8_t>(number);
  status.responds = responds;
  status.synchronized = synchronized;
  std::snprintf(status.state, sizeof status.state, "%s", state);
  return status;
}

WaitLook look(std::uint32_t wanted, std::uint16_t option_status = 0x0080,
              const char* controller = "error-active") {
  WaitLook now;
  now.wanted = wanted;
  now.master.option_status = option_status;
  now.controller = controller;
  now.slaves = {slave(0, "released", true, true), slave(1, "held", true, true),
                slave(2, "lost", false, false)};
  return now;
}

bool reached(const char* state, const WaitLook& now) {
  return is_reached(find_wait_state(state), now);
}

TEST(WaitStates, OfTheMaster) {
  EXPECT_TRUE(reached("run", look(0, 0x0080)));
  EXPECT_FALSE(reached("setup", look(0, 0x0080)));
  EXPECT_TRUE(reached("setup", look(0, 0x0043)));
  for (const std::uint16_t stopped : {std::uint16_t{1}, std::uint16_t{2}, std::uint16_t{3}})
    EXPECT_TRUE(reached("stop", look(0, stopped)));
  EXPECT_FALSE(reached("stop", look(0, 0x0043)));
  EXPECT_TRUE(reached("bus-off", look(0, 0x0080, "bus-off")));
  EXPECT_FALSE(reached("error-active", look(0, 0x0080, "bus-off")));
}

TEST(WaitStates, OfSlavesWhenAllOfThemAreInIt) {
  EXPECT_TRUE(reached("responding", look(0b011)));
  EXPECT_TRUE(reached("synchronized", look(0b011)));
  EXPECT_FALSE(reached("responding", look(0b111)));
  EXPECT_TRUE(reached("released", look(0b001)));
  EXPECT_FALSE(reached("released", look(0b011)));
  EXPECT_TRUE(reached("held", look(0b010)));
  EXPECT_TRUE(reached("lost", look(0b100)));
}

TEST(WaitStates, SlavesThatAreNotKnownAreInNoState) {
  EXPECT_FALSE(reached("released", look(0b1001)));
  EXPECT_FALSE(reached("absent", look(0b1000)));
  EXPECT_FALSE(reached("released", look(0)));
}

TEST(WaitStates, SlavesThatNobodyAsksAreInNoState) {
  for (const std::uint16_t stopped : {std::uint16_t{1}, std::uint16_t{2}, std::uint16_t{3}})
    EXPECT_FALSE(reached("synchronized", look(0b001, stopped)));
  EXPECT_TRUE(reached("synchronized", look(0b001, 0x0043)));
  WaitLook stopped = look(0b001, 2);
  std::snprintf(stopped.master.state, sizeof stopped.master.state, "stop");
  EXPECT_EQ(seen(find_wait_state("synchronized"), stopped), "the line is in stop: no slave is asked");
}

TEST(WaitStates, SayWhatIsTheCase) {
  EXPECT_EQ(seen(find_wait_state("released"), look(0b1011)),
            "slave 1 is held, responds, synchronized; nothing of slaves 3");
  EXPECT_EQ(seen(find_wait_state("bus-off"), look(0)), "the controller is error-active");
}

TEST(WaitStates, UnknownOnesAreToldWithAllThereAre) {
  try {
    static_cast<void>(find_wait_state("ready"));
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_EQ(std::string(error.what()).find("STATE: found 'ready'; allowed: present, gone, setup, run,"), 0u)
        << error.what();
  }
}

}  // namespace
}  // namespace cansync::cli
