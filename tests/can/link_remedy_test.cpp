#include "can/adapter/link_remedy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string_view>

namespace can {
namespace {

LinkFacts down(std::string_view driver) {
  LinkFacts link;
  link.present = true;
  link.is_can = true;
  std::copy(driver.begin(), driver.end(), link.driver_kind.begin());
  return link;
}

TEST(LinkRemedy, AVirtualInterfaceHasNoBitRate) {
  EXPECT_EQ(link_remedy("vcan0", down("vcan")), "ip link set vcan0 up");
  EXPECT_EQ(link_remedy("line", down("vcan"), 500000), "ip link set line up");
  EXPECT_EQ(link_remedy("vx1", down("vxcan")), "ip link set vx1 up");
  EXPECT_EQ(link_remedy("vcan0", LinkFacts{}), "ip link add dev vcan0 type vcan && ip link set vcan0 up");
}

TEST(LinkRemedy, ASerialOneHasThatOfItsDaemon) {
  EXPECT_EQ(link_remedy("slcan0", down("")).find("ip link set slcan0 up   (its bit rate is that of slcand"),
            0u);
  EXPECT_EQ(link_remedy("slcan0", down("can"), 250000).find("ip link set slcan0 up   "), 0u);
  EXPECT_EQ(link_remedy("slcan0", LinkFacts{}).find("slcand -o -s6 /dev/ttyACM0 slcan0 && "), 0u);
}

TEST(LinkRemedy, AnAdapterNeedsABitRateUnlessItHasIt) {
  LinkFacts link = down("can");
  EXPECT_EQ(link_remedy("can0", link),
            "ip link set can0 up type can bitrate 500000   (the bit rate of the bus)");
  EXPECT_EQ(link_remedy("can0", link, 250000), "ip link set can0 up type can bitrate 250000");
  link.timing = LinkTiming{250000, 875};
  EXPECT_EQ(link_remedy("can0", link), "ip link set can0 up");
  EXPECT_EQ(link_remedy("can0", link, 250000), "ip link set can0 up");
  EXPECT_EQ(link_remedy("can0", link, 500000), "ip link set can0 up type can bitrate 500000");
}

TEST(LinkRemedy, AnAdapterThatIsMissingIsPluggedIn) {
  EXPECT_EQ(link_remedy("can0", LinkFacts{}).find("plug the adapter in or load its driver"), 0u);
}

}  // namespace
}  // namespace can
