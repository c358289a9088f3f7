// What the program does on an interface that is not virtual before it sends.

#include "simulator/first_look.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string_view>

#include "rig.h"

namespace {

using namespace std::chrono_literals;
using namespace cansync_sim;

can::LinkFacts driven_by(std::string_view kind) {
  can::LinkFacts facts;
  facts.present = true;
  std::copy(kind.begin(), kind.end(), facts.driver_kind.begin());
  return facts;
}

cansync_sim::Setup with_drives(std::initializer_list<unsigned> numbers) {
  cansync_sim::Setup setup;
  setup.interface = "can0";
  for (const unsigned number : numbers)
    setup.drives.emplace_back().slave.number = *cansync::SlaveNumber::from(number);
  return setup;
}

Heard heard_of(std::initializer_list<const char*> frames) {
  Heard heard;
  for (const char* one : frames) hear(frame(one), 0x080, heard);
  return heard;
}

TEST(FirstLook, VirtualInterfacesReachNoDevice) {
  EXPECT_TRUE(is_virtual(driven_by("vcan")));
  EXPECT_TRUE(is_virtual(driven_by("vxcan")));
  EXPECT_FALSE(is_virtual(driven_by("can")));
  EXPECT_FALSE(is_virtual(driven_by("slcan")));
  EXPECT_FALSE(is_virtual({}));
}

TEST(FirstLook, KnowsMastersAndSlavesByTheirFrames) {
  EXPECT_FALSE(heard_of({"7FF#01", "080#01", "581#03"}).master) << "no SYNC, no telegram";
  EXPECT_EQ(heard_of({"080#"}).master, 0x080u);
  EXPECT_EQ(heard_of({"103#0000000000000000"}).master, 0x103u);
  EXPECT_EQ(heard_of({"503#70670000"}).master, 0x503u);
  const Heard slaves = heard_of({"583#006703000000", "302#0000000000000000"});
  EXPECT_FALSE(slaves.master);
  EXPECT_EQ(slaves.slaves.bits, 0b1100u);
}

TEST(FirstLook, ListensASecondWithTheInterfaceUp) {
  ScriptedPort port;
  port.arrives(500ms, "583#006703000000");
  port.stops(10s);
  const auto heard = listen(port, 0x080);
  ASSERT_TRUE(heard);
  EXPECT_EQ(heard->slaves.bits, 0b1000u);
  EXPECT_GE(port.now(), 1s);
  EXPECT_TRUE(port.sent().empty());
}

TEST(FirstLook, EndsWhenItIsToStop) {
  ScriptedPort port;
  port.stops(500ms);
  EXPECT_FALSE(listen(port, 0x080));
}

TEST(FirstLook, DrivesMustNotHaveNumbersThatAreThere) {
  const Heard heard = heard_of({"080#", "503#70670000", "583#006703000000"});
  EXPECT_EQ(conflict(with_drives({0, 1}), heard), "") << "a master is what they wait for";
  EXPECT_NE(conflict(with_drives({0, 3}), heard).find("can0: slave 3 responds on this bus"),
            std::string::npos);
}

TEST(FirstLook, AMasterMustBeTheOnlyOne) {
  cansync_sim::Setup setup;
  setup.interface = "can0";
  setup.master.emplace();
  EXPECT_EQ(conflict(setup, heard_of({"583#006703000000"})), "");
  EXPECT_NE(conflict(setup, heard_of({"103#0000000000000000"})).find("a master sends on this bus"),
            std::string::npos);
}

}  // namespace
