#include "can/link_watch.h"

#include <gtest/gtest.h>
#include <linux/can/netlink.h>
#include <linux/if.h>
#include <linux/if_arp.h>
#include <linux/if_link.h>
#include <linux/rtnetlink.h>

#include <cstring>
#include <stop_token>
#include <vector>

#include "fake_kernel.h"

namespace can::test {
namespace {

using Bytes = std::vector<std::byte>;

/// Builds netlink messages as the kernel does.
class Message {
 public:
  explicit Message(bool up = true, int index = 5, unsigned short type = ARPHRD_CAN) {
    ifinfomsg link{};
    link.ifi_index = index;
    link.ifi_type = type;
    link.ifi_flags = (up ? IFF_UP : 0) | IFF_ECHO;
    nlmsghdr header{};
    header.nlmsg_type = RTM_NEWLINK;
    append(header);
    append(link);
  }
  template <class T>
  void append(const T& value) {
    const auto* bytes = reinterpret_cast<const std::byte*>(&value);
    bytes_.insert(bytes_.end(), bytes, bytes + sizeof(T));
  }
  void add(unsigned short type, const void* payload, std::size_t size) {
    append(rtattr{static_cast<unsigned short>(sizeof(rtattr) + size), type});
    const auto* bytes = static_cast<const std::byte*>(payload);
    if (size != 0) bytes_.insert(bytes_.end(), bytes, bytes + size);
    while (bytes_.size() % 4 != 0) bytes_.push_back(std::byte{0});
  }
  void add_text(unsigned short type, const std::string& text) { add(type, text.c_str(), text.size() + 1); }
  template <class T>
  void add_value(unsigned short type, const T& value) {
    add(type, &value, sizeof(value));
  }
  std::size_t open(unsigned short type) {
    const std::size_t at = bytes_.size();
    add(type, nullptr, 0);
    return at;
  }
  void close(std::size_t at) {
    const auto length = static_cast<unsigned short>(bytes_.size() - at);
    std::memcpy(bytes_.data() + at, &length, sizeof(length));
  }
  Bytes bytes() {
    const auto length = static_cast<std::uint32_t>(bytes_.size());
    std::memcpy(bytes_.data(), &length, sizeof(length));
    return bytes_;
  }

 private:
  Bytes bytes_;
};

Bytes real_controller() {
  Message message;
  message.add_text(IFLA_IFNAME, "can0");
  message.add_value(IFLA_TXQLEN, std::uint32_t{10});
  const std::size_t info = message.open(IFLA_LINKINFO);
  message.add_text(IFLA_INFO_KIND, "can");
  const std::size_t data = message.open(IFLA_INFO_DATA);
  can_bittiming timing{};
  timing.bitrate = 500'000;
  timing.sample_point = 875;
  message.add_value(IFLA_CAN_BITTIMING, timing);
  message.add_value(IFLA_CAN_STATE, std::uint32_t{CAN_STATE_ERROR_PASSIVE});
  message.add_value(IFLA_CAN_CTRLMODE, can_ctrlmode{0, CAN_CTRLMODE_ONE_SHOT | CAN_CTRLMODE_BERR_REPORTING});
  const std::size_t modes = message.open(IFLA_CAN_CTRLMODE_EXT);
  message.add_value(IFLA_CAN_CTRLMODE_SUPPORTED, std::uint32_t{CAN_CTRLMODE_ONE_SHOT});
  message.close(modes);
  message.add_value(IFLA_CAN_RESTART_MS, std::uint32_t{100});
  message.add_value(IFLA_CAN_BERR_COUNTER, can_berr_counter{130, 7});
  message.close(data);
  message.close(info);
  return message.bytes();
}

TEST(LinkMessage, TellsEverythingAboutARealController) {
  const auto facts = read_link_message(real_controller(), "can0");
  ASSERT_TRUE(facts);
  LinkFacts expected = can0(500'000);
  expected.timing->sample_point = 875;
  expected.queue_length = 10;
  expected.driver_kind = {'c', 'a', 'n'};
  expected.state = ControllerState::error_passive;
  expected.restart_ms = 100;
  expected.echoes = true;
  expected.one_shot = true;
  expected.can_one_shot = true;
  expected.has_counters = true;
  expected.transmit_errors = 130;
  expected.receive_errors = 7;
  EXPECT_EQ(*facts, expected);
}

TEST(LinkMessage, AVirtualInterfaceHasNeitherTimingNorController) {
  Message message(false, 3);
  message.add_text(IFLA_IFNAME, "vcan0");
  const std::size_t info = message.open(IFLA_LINKINFO);
  message.add_text(IFLA_INFO_KIND, "vcan");
  message.close(info);
  const auto facts = read_link_message(message.bytes(), "vcan0");
  ASSERT_TRUE(facts);
  EXPECT_TRUE(facts->is_can);
  EXPECT_FALSE(facts->up);
  EXPECT_FALSE(facts->timing);
  EXPECT_FALSE(facts->state);
  EXPECT_FALSE(facts->restart_ms);
  EXPECT_FALSE(facts->one_shot);
}

TEST(LinkMessage, AnotherInterfaceOrNoneTellsNothing) {
  EXPECT_FALSE(read_link_message(real_controller(), "can1"));
  EXPECT_FALSE(read_link_message({}, "can0"));
  Message ethernet(true, 2, ARPHRD_ETHER);
  ethernet.add_text(IFLA_IFNAME, "eth0");
  const auto facts = read_link_message(ethernet.bytes(), "eth0");
  ASSERT_TRUE(facts);
  EXPECT_FALSE(facts->is_can);
}

TEST(LinkMessage, WhateverIsCutOffOrWrongIsReadWithinItsBytes) {
  const Bytes whole = real_controller();
  for (std::size_t size = 0; size < whole.size(); ++size) {
    // A copy of exactly this size, so that a sanitizer sees one byte too many.
    const Bytes part(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_FALSE(read_link_message(part, "can0")) << size;
  }
  for (std::size_t at = 0; at < whole.size(); ++at) {
    for (const unsigned value : {0x00u, 0x01u, 0x7Fu, 0xFFu}) {
      Bytes wrong = whole;
      wrong[at] = std::byte{static_cast<unsigned char>(value)};
      const auto facts = read_link_message(wrong, "can0");
      if (facts) {
        EXPECT_TRUE(facts->present);
      }
    }
  }
}

TEST(LinkState, SaysWhatStandsInTheWay) {
  LinkFacts facts = can0(500'000);
  EXPECT_EQ(link_state({}, 500'000), LinkState::missing);
  EXPECT_EQ(link_state(facts, 500'000), LinkState::up);
  EXPECT_EQ(link_state(facts, 250'000), LinkState::wrong_bit_rate);
  facts.timing->bits_per_second = 497'500;
  EXPECT_EQ(link_state(facts, 500'000), LinkState::up) << "the controller's clock does not divide exactly";
  facts.timing->bits_per_second = 497'499;
  EXPECT_EQ(link_state(facts, 500'000), LinkState::wrong_bit_rate) << "over 0.5 %";
  facts.timing->bits_per_second = 502'500;
  EXPECT_EQ(link_state(facts, 500'000), LinkState::up);
  EXPECT_EQ(link_state(facts, 500'000, true), LinkState::up) << "nothing is known of one-shot";
  facts.one_shot = false;
  EXPECT_EQ(link_state(facts, 500'000), LinkState::up);
  EXPECT_EQ(link_state(facts, 500'000, true), LinkState::not_one_shot);
  facts.listen_only = true;
  EXPECT_EQ(link_state(facts, 500'000), LinkState::listen_only);
  facts.listen_only = false;
  facts.timing.reset();
  EXPECT_EQ(link_state(facts, 250'000), LinkState::up) << "a virtual interface has no bit rate";
  facts.up = false;
  EXPECT_EQ(link_state(facts, 500'000), LinkState::down);
  facts.is_can = false;
  EXPECT_EQ(link_state(facts, 500'000), LinkState::missing);
}

struct Rig {
  FakeLinks links;
  LinkBoard board;
  FakeKernel kernel;
  BusSockets sockets{{}, kernel};
  LinkWatch watch{links, board, sockets, {"can0", 1'000'000}};
  std::uint32_t resets = 0;

  ResetResult reset() {
    board.want_reset(++resets);
    watch.look();
    return board.reset_result(resets).value_or(ResetResult::pending);
  }
};

TEST(LinkWatch, ResetsAsTheControllersStateAsks) {
  Rig rig;
  rig.links.facts = can0();
  rig.links.facts.state = ControllerState::bus_off;
  EXPECT_EQ(rig.reset(), ResetResult::done);
  EXPECT_EQ(rig.links.asked, std::vector<std::string>{"restart 5"});

  // The kernel restarts it by itself and refuses to be told; and one that is not bus-off cannot be restarted.
  for (const ControllerState state : {ControllerState::bus_off, ControllerState::error_passive}) {
    rig.links.asked.clear();
    rig.links.facts = can0();
    rig.links.facts.state = state;
    rig.links.facts.restart_ms = state == ControllerState::bus_off ? 100 : 0;
    EXPECT_EQ(rig.reset(), ResetResult::done);
    EXPECT_EQ(rig.links.asked, (std::vector<std::string>{"down 5", "up 5"}));
  }
}

TEST(LinkWatch, SaysWhyItCannotReset) {
  Rig rig;
  EXPECT_EQ(rig.reset(), ResetResult::unavailable) << "missing";
  rig.links.facts = can0();
  rig.links.facts.up = false;
  EXPECT_EQ(rig.reset(), ResetResult::unavailable) << "down";
  EXPECT_TRUE(rig.links.asked.empty());

  rig.links.facts = can0();
  rig.links.facts.state = ControllerState::bus_off;
  rig.links.restart_result = -EPERM;
  EXPECT_EQ(rig.reset(), ResetResult::not_permitted);
  rig.links.restart_result = -EOPNOTSUPP;
  EXPECT_EQ(rig.reset(), ResetResult::unavailable);

  rig.links.facts.state = ControllerState::error_passive;
  rig.links.set_up_result = -EPERM;
  rig.links.asked.clear();
  EXPECT_EQ(rig.reset(), ResetResult::not_permitted);
  EXPECT_EQ(rig.links.asked, std::vector<std::string>{"down 5"}) << "not half";
}

TEST(LinkWatch, AnInterfaceThatAResetHasLeftDownIsSetUpAsSoonAsThatWorks) {
  Rig rig;
  rig.links.facts = can0();
  rig.links.facts.state = ControllerState::error_passive;
  rig.links.up_result = -ETIMEDOUT;
  EXPECT_EQ(rig.reset(), ResetResult::unavailable);
  EXPECT_FALSE(rig.links.facts.up);
  rig.watch.look();
  EXPECT_EQ(rig.board.link().state, LinkState::down);
  rig.links.up_result = 0;
  rig.watch.look();
  EXPECT_EQ(rig.board.link().state, LinkState::up);
  EXPECT_EQ(rig.links.asked, (std::vector<std::string>{"down 5", "up 5", "up 5", "up 5"}));

  rig.links.facts.up = false;  // by somebody else
  rig.watch.look();
  EXPECT_EQ(rig.board.link().state, LinkState::down);
  EXPECT_EQ(rig.links.asked.size(), 4u) << "who sets it down wants it so";
}

LinkFacts with_serial(char serial) {
  LinkFacts facts = can0();
  facts.adapter.serial = {serial};
  return facts;
}

TEST(LinkWatch, AnotherAdapterIsNeitherUsedNorReset) {
  Rig rig;
  LinkWatch watch{rig.links, rig.board, rig.sockets, {"can0", 1'000'000, false, read_pin("serial=A").pin}};
  rig.links.facts = with_serial('A');
  watch.look();
  EXPECT_EQ(rig.board.link().state, LinkState::up);
  EXPECT_EQ(rig.board.link().index, 5u);

  for (const LinkFacts& wrong : {with_serial('B'), can0()}) {
    rig.links.facts = wrong;
    rig.links.facts.up = false;
    watch.look();
    EXPECT_EQ(rig.board.link().state, LinkState::wrong_adapter) << "also while it is down";
    EXPECT_EQ(rig.board.link().index, 0u) << "nothing of another line is received";
    rig.links.facts.up = true;
    rig.links.facts.state = ControllerState::bus_off;
    rig.board.want_reset(++rig.resets);
    watch.look();
    EXPECT_EQ(rig.board.reset_result(rig.resets), ResetResult::unavailable);
    EXPECT_TRUE(rig.links.asked.empty()) << "it is the controller of another line";
  }
  rig.links.facts = with_serial('A');
  watch.look();
  EXPECT_EQ(rig.board.link().state, LinkState::up);
}

/// What an event is made of must be there before the realtime thread can report it.
TEST(LinkWatch, TellsWhatItFoundBeforeTheBoardHasIt) {
  FakeLinks links;
  LinkBoard board;
  FakeKernel kernel;
  BusSockets sockets{{}, kernel};
  LinkWatch watch{links, board, sockets, {"can0", 1'000'000, false, read_pin("serial=A").pin}};
  std::stop_source stop;
  std::vector<LinkState> board_had;
  std::vector<char> found;
  unsigned looks = 0;
  links.on_wait = [&] {
    if (++looks == 2) links.facts = with_serial('B');
    if (looks == 4) stop.request_stop();
  };
  links.facts = with_serial('A');
  watch.run(stop.get_token(), [&](const LinkFacts& facts) {
    board_had.push_back(board.link().state);
    found.push_back(facts.adapter.serial.front());
  });
  EXPECT_EQ(found, (std::vector<char>{'A', 'B'})) << "each change once";
  EXPECT_EQ(board_had, (std::vector{LinkState::missing, LinkState::up}));
  EXPECT_EQ(board.link().state, LinkState::wrong_adapter);
}

TEST(LinkWatch, AVirtualInterfaceHasNothingToReset) {
  Rig rig;
  rig.links.facts = can0();
  rig.links.facts.state.reset();
  EXPECT_EQ(rig.reset(), ResetResult::done);
  EXPECT_TRUE(rig.links.asked.empty());
}

TEST(LinkKernel, KnowsTheLoopbackInterfaceOfThisMachine) {
  const auto kernel = make_link_kernel();
  const LinkFacts facts = kernel->read("lo");
  EXPECT_TRUE(facts.present);
  EXPECT_FALSE(facts.is_can);
  EXPECT_FALSE(kernel->read("no-such-one").present);
  EXPECT_EQ(kernel->read("lo"), facts) << "after an error as before";
}

TEST(LinkKernel, AnInterruptEndsTheWait) {
  const auto kernel = make_link_kernel();
  kernel->interrupt();
  kernel->wait(std::chrono::hours(1));
}

}  // namespace
}  // namespace can::test
