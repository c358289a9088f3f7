#include "daemon/status/status_line.h"

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "daemon/cansync/status/status_text.h"
#include "daemon/cansync_slave/gateway/slave_status.h"
#include "daemon/service/heartbeat.h"

namespace {

using namespace cansyncd;
using namespace std::chrono_literals;

/// A line of `slaves` configured slaves "slave0", "slave1", ... on can0 at 500 kbit/s.
Config line_of(unsigned slaves) {
  Config config;
  config.bus.name = "line";
  config.bus.interface = "can0";
  config.master.bit_rate = cansync::BitRate::kbit500;
  for (unsigned i = 0; i < slaves; ++i) {
    config.master.slaves[i].configured = true;
    config.slaves[i].name = "slave" + std::to_string(i);
  }
  return config;
}

MasterSnapshot active_with(std::uint32_t responding) {
  MasterSnapshot master;
  master.state = cansync::State::active_master;
  master.responding.bits = responding;
  return master;
}

TEST(StatusText, TellsStateSlavesAndBus) {
  EXPECT_EQ(status_text(active_with(0b11), line_of(2)),
            "run: 2 of 2 slaves respond; bus line (can0) at 500000 bit/s");
}

TEST(StatusText, NamesFourOfThoseThatDoNotAnswer) {
  EXPECT_EQ(status_text(active_with(0b10), line_of(2)),
            "run: 1 of 2 slaves respond; no answer from slave0; bus line (can0) at 500000 bit/s");
  EXPECT_EQ(status_text(active_with(0b1), line_of(7)),
            "run: 1 of 7 slaves respond; no answer from slave1, slave2, slave3, slave4 and 2 more; "
            "bus line (can0) at 500000 bit/s");
}

TEST(StatusText, TellsFirstWhatKeepsTheLineFromRunning) {
  MasterSnapshot master = active_with(0);
  master.controller.link = can::LinkState::missing;
  EXPECT_EQ(status_text(master, line_of(2)), "waiting for interface can0: it is missing");
  master.controller.link = can::LinkState::down;
  EXPECT_EQ(status_text(master, line_of(2)), "waiting for interface can0: it is down");
  master.controller.link = can::LinkState::wrong_adapter;
  EXPECT_EQ(status_text(master, line_of(2)),
            "nothing is sent: interface can0 has another adapter than bus.adapter");
  master.controller.link = can::LinkState::wrong_bit_rate;
  EXPECT_EQ(status_text(master, line_of(2)),
            "nothing is sent: interface can0 has another bit rate than the configured one");
  master.controller.link = can::LinkState::up;
  master.controller.state = can::ControllerState::bus_off;
  EXPECT_EQ(status_text(master, line_of(2)), "nothing is sent: the controller of can0 is bus-off");
}

TEST(BusSentence, OfEveryProtocolSaysFirstWhatKeepsItFromSending) {
  const BusConfig bus = line_of(1).bus;
  can::ControllerStatus controller;
  EXPECT_EQ(bus_sentence("J1939: has address 128", controller, bus),
            "J1939: has address 128; bus line (can0) at 1000000 bit/s");
  controller.delivery = can::Delivery::unacknowledged;
  EXPECT_EQ(
      bus_sentence("J1939: has address 128", controller, bus),
      "nobody on the bus of interface can0 acknowledges: check cable, terminating resistors and the power of "
      "the other nodes");
  controller.link = can::LinkState::listen_only;
  EXPECT_EQ(bus_sentence("run", controller, bus), "nothing is sent: interface can0 is in listen-only mode");
}

TEST(SlaveSentence, TellsStateAndWhatIsWrongWithIt) {
  SlaveRoleConfig config;
  config.bus.name = "upper";
  config.bus.interface = "can0";
  config.slave.number = *cansync::SlaveNumber::from(5);
  config.slave.bit_rate = cansync::BitRate::kbit500;
  SlaveSnapshot slave;
  slave.state = cansync::State::active_slave;
  slave.activated = slave.synchronized = true;
  const std::string bus = "; bus upper (can0) at 500000 bit/s";
  const std::string run = "slave 5: " + std::string(cansync::name(slave.state));
  EXPECT_EQ(slave_sentence(slave, config), run + bus);
  slave.synchronized = false;
  EXPECT_EQ(slave_sentence(slave, config), run + "; not synchronized" + bus);
  slave.activated = false;
  EXPECT_EQ(slave_sentence(slave, config), run + "; not activated by the master" + bus);
  slave.fault = cansync::SlaveFault::references_missing;
  EXPECT_EQ(slave_sentence(slave, config), run + "; no reference values" + bus);
  slave.fault = cansync::SlaveFault::sync_lost;
  EXPECT_EQ(slave_sentence(slave, config), run + "; no SYNC of the master" + bus);
  slave.controller.link = can::LinkState::missing;
  EXPECT_EQ(slave_sentence(slave, config), "waiting for interface can0: it is missing");
}

TEST(StatusText, TellsOfAnotherMaster) {
  MasterSnapshot master = active_with(1);
  master.second_master = true;
  EXPECT_EQ(status_text(master, line_of(1)),
            "run: 1 of 1 slave responds; bus line (can0) at 500000 bit/s; another master sends");
}

TEST(StatusText, TellsFirstThatAnotherMasterKeepsItSilent) {
  MasterSnapshot master = active_with(0);
  master.state = cansync::State::waiting_for_start;
  master.access = cansync::BusAccess::listening;
  EXPECT_EQ(status_text(master, line_of(1)),
            "listening for another master: 0 of 1 slave responds; no answer from slave0; bus line (can0) at "
            "500000 bit/s");
  master.access = cansync::BusAccess::other_master;
  master.second_master = true;
  master.second_master_identifier = 0x105;
  EXPECT_EQ(status_text(master, line_of(1)),
            "silent: another master on the bus of interface can0 (identifier 0x105); switch one of them off");
  master.second_master_identifier = 0;
  EXPECT_EQ(status_text(master, line_of(1)),
            "silent: another master on the bus of interface can0 (a SYNC frame); switch one of them off");
  master.access = cansync::BusAccess::granted;
  master.second_master = false;
  master.waits_for_command = true;
  EXPECT_EQ(
      status_text(master, line_of(1)),
      "waiting for a command: another master was on the bus of interface can0; start with: cansync mode "
      "setup");
}

TEST(StatusLine, IsToldOnTheEdgeAndAtMostOnceASecond) {
  std::vector<std::string> told;
  StatusLine line([&](const std::string& text) { told.push_back(text); });
  const StatusLine::Time start{};
  const auto step = [&](const char* text, StatusLine::Time now) {
    return line.step([text] { return std::string(text); }, now);
  };
  EXPECT_FALSE(step("run", start));
  EXPECT_EQ(told.size(), 1U);
  EXPECT_EQ(step("stop", start + 400ms), start + 1s);
  EXPECT_EQ(told.size(), 1U);
  EXPECT_FALSE(step("stop", start + 1s));
  EXPECT_EQ(told.size(), 2U);
  EXPECT_FALSE(step("stop", start + 5s));
  EXPECT_EQ(told.size(), 2U);
}

TEST(Heartbeat, BeatsOnlyWhenBothThreadsHaveComeFurther) {
  Heartbeat heartbeat(4s);
  EXPECT_EQ(heartbeat.period(), 1s);
  const auto looks = [&](Heartbeat::Progress now) { return heartbeat.look({&now, 1}); };
  EXPECT_TRUE(looks({1, 1}));
  EXPECT_FALSE(looks({1, 1}));
  EXPECT_FALSE(looks({2, 1})) << "the gateway thread stands still";
  EXPECT_FALSE(looks({3, 1}));
  EXPECT_TRUE(looks({4, 2}));
  EXPECT_FALSE(looks({4, 9})) << "the realtime thread stands still";
  EXPECT_TRUE(looks({5, 9}));
}

TEST(Heartbeat, BeatsOnlyWhenEveryBusHasComeFurther) {
  Heartbeat heartbeat(4s);
  std::array<Heartbeat::Progress, 2> now = {{{1, 1}, {1, 1}}};
  EXPECT_TRUE(heartbeat.look(now));
  now[1] = {2, 2};
  EXPECT_FALSE(heartbeat.look(now)) << "the first bus stands still";
  now[0] = {2, 1};
  EXPECT_FALSE(heartbeat.look(now)) << "its gateway thread stands still";
  now[0] = {2, 2};
  EXPECT_TRUE(heartbeat.look(now));
}

TEST(Heartbeat, HasNoPeriodWithoutAWatchdog) {
  EXPECT_FALSE(Heartbeat(std::nullopt).period());
}

}  // namespace
