#include "daemon/service/network_watch.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>

namespace cansyncd {
namespace {

/// An interface that does what the test says.
struct MadeUpNetwork {
  NetworkLink link;
  unsigned asked = 0;
  NetworkWatch::Source source() {
    return [this](const std::string& interface) {
      EXPECT_EQ(interface, "eth1");
      ++asked;
      return link;
    };
  }
};

NetworkLink usable(const std::string& address) {
  return {7, true, {address}};
}

std::string local_reason(const std::string& what) {
  return "network interface 'eth1' (dds.interface) " + what + ": only clients of this computer are served";
}

TEST(NetworkWatch, StartsOnTheInterfaceThatCanBeUsed) {
  MadeUpNetwork network{usable("10.0.0.1")};
  NetworkWatch watch("eth1", network.source());
  EXPECT_EQ(watch.place(), (NetworkPlace{"eth1", "7 10.0.0.1", ""}));
  EXPECT_FALSE(watch.look());
}

TEST(NetworkWatch, SaysWhyAnInterfaceCannotBeUsed) {
  for (const auto& [link, what] :
       {std::pair(NetworkLink{}, "does not exist"), std::pair(NetworkLink{7, false, {"10.0.0.1"}}, "is down"),
        std::pair(NetworkLink{7, true, {}}, "has no IPv4 address")}) {
    MadeUpNetwork network{link};
    const NetworkWatch watch("eth1", network.source());
    EXPECT_EQ(watch.place(), (NetworkPlace{"lo", "", local_reason(what)}));
  }
}

TEST(NetworkWatch, FollowsAnInterfaceThatTwoLooksHaveFoundAlike) {
  MadeUpNetwork network;
  NetworkWatch watch("eth1", network.source());
  network.link = usable("10.0.0.1");
  EXPECT_FALSE(watch.look()) << "it may still change";
  EXPECT_TRUE(watch.look());
  EXPECT_EQ(watch.place().interface, "eth1");
  EXPECT_EQ(watch.place().reason, "");
  network.link = usable("10.0.0.2");
  EXPECT_FALSE(watch.look());
  EXPECT_TRUE(watch.look());
  EXPECT_EQ(watch.place().link, "7 10.0.0.2");
  network.link.index = 8;  // removed and made again
  EXPECT_FALSE(watch.look());
  EXPECT_TRUE(watch.look());
  EXPECT_EQ(watch.place().link, "8 10.0.0.2");
  network.link = {};
  EXPECT_FALSE(watch.look());
  EXPECT_TRUE(watch.look());
  EXPECT_EQ(watch.place(), (NetworkPlace{"lo", "", local_reason("does not exist")}));
}

TEST(NetworkWatch, AnInterfaceThatFluttersMovesNothing) {
  MadeUpNetwork network{usable("10.0.0.1")};
  NetworkWatch watch("eth1", network.source());
  for (int i = 0; i < 10; ++i) {
    network.link = i % 2 == 0 ? NetworkLink{} : usable("10.0.0.1");
    EXPECT_FALSE(watch.look());
  }
  EXPECT_EQ(watch.place().interface, "eth1");
}

TEST(NetworkWatch, LoopbackIsNotLookedAt) {
  MadeUpNetwork network;
  NetworkWatch watch("lo", network.source());
  EXPECT_FALSE(watch.look());
  EXPECT_EQ(watch.place(), (NetworkPlace{"lo", "", ""}));
  EXPECT_EQ(network.asked, 0u);
}

TEST(NetworkWatch, TheKernelKnowsLoopbackAndNoOther) {
  const NetworkLink loopback = kernel_network_link("lo");
  EXPECT_NE(loopback.index, 0u);
  EXPECT_TRUE(loopback.up);
  EXPECT_EQ(loopback.addresses.front(), "127.0.0.1");
  EXPECT_EQ(kernel_network_link("nosuch0"), NetworkLink{});
}

}  // namespace
}  // namespace cansyncd
