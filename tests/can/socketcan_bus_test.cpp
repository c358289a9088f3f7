#include "can/socketcan/socketcan_bus.h"

#include <gtest/gtest.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <linux/net_tstamp.h>

#include <chrono>
#include <system_error>

#include "can/link_watch.h"
#include "fake_kernel.h"

namespace can::test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

can_frame raw(std::uint32_t id, std::uint8_t length = 0) {
  can_frame frame{};
  frame.can_id = id;
  frame.len = length;
  return frame;
}

Frame frame(std::uint32_t id) {
  Frame out;
  out.id = id;
  return out;
}

/// A bus on a fake kernel, with the watch of its interface called by hand.
struct Rig {
  explicit Rig(const LinkFacts& facts = can0(), bool wake_on_frame = false)
      : bus((links.facts = facts, watch.look(), SocketcanSettings{wake_on_frame}), board, links, kernel) {}

  FakeKernel kernel;
  FakeLinks links;
  LinkBoard board;
  BusSockets sockets{{{.identifier = 0x010},
                      {.identifier = 0x100, .mask = 0x780},
                      {0x18DAF110, CAN_EFF_MASK, FlagFilter::set, FlagFilter::set}},
                     kernel};
  LinkWatch watch{links, board, sockets, {"can0", 1'000'000}};
  SocketcanBus bus;

  /// A frame with the kernel's stamp of now, `ago` before.
  void arrive(std::uint32_t id, Time ago = Time{0}, bool own = false) {
    Arriving one;
    one.frame = raw(id);
    one.own = own;
    one.software = kernel.now - ago + kernel.wall_offset;
    kernel.arriving.push_back(one);
  }
  void arrive_error(std::uint32_t kind, std::uint8_t controller = 0) {
    Arriving one;
    one.frame = raw(CAN_ERR_FLAG | kind, 8);
    one.frame.data[1] = controller;
    kernel.arriving.push_back(one);
  }
  /// Sleeps 1 ms and takes everything.
  std::vector<ReceivedFrame> next() {
    EXPECT_EQ(bus.wait_until(kernel.now + milliseconds(1)), Wake::deadline);
    return take();
  }
  std::vector<ReceivedFrame> take() {
    std::vector<ReceivedFrame> out;
    ReceivedFrame one;
    while (bus.receive(one)) out.push_back(one);
    return out;
  }
};

TEST(SocketcanBus, SetsTheSocketUpAsNeeded) {
  const Rig rig;
  const auto& options = rig.kernel.options;
  EXPECT_EQ(options.at({SOL_CAN_RAW, CAN_RAW_ERR_FILTER}), static_cast<int>(CAN_ERR_MASK));
  EXPECT_EQ(options.at({SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS}), 1);
  EXPECT_EQ(options.at({SOL_CAN_RAW, CAN_RAW_LOOPBACK}), 1);
  EXPECT_EQ(options.at({SOL_SOCKET, SO_RXQ_OVFL}), 1);
  EXPECT_EQ(options.at({SOL_SOCKET, SO_SNDBUF}), 0);
  EXPECT_EQ(options.at({SOL_SOCKET, SO_TIMESTAMPING}),
            SOF_TIMESTAMPING_RX_SOFTWARE | SOF_TIMESTAMPING_SOFTWARE | SOF_TIMESTAMPING_RX_HARDWARE |
                SOF_TIMESTAMPING_RAW_HARDWARE);
  ASSERT_EQ(rig.kernel.filters.size(), 3u);
  EXPECT_EQ(rig.kernel.filters[1].can_id, 0x100u);
  EXPECT_EQ(rig.kernel.filters[1].can_mask, 0x780u | CAN_EFF_FLAG | CAN_RTR_FLAG);
  EXPECT_EQ(rig.kernel.filters[2].can_id, 0x18DAF110u | CAN_EFF_FLAG | CAN_RTR_FLAG);
  EXPECT_EQ(rig.kernel.filters[2].can_mask, CAN_EFF_MASK | CAN_EFF_FLAG | CAN_RTR_FLAG);
  EXPECT_EQ(rig.kernel.bound, std::vector<int>{5});
}

TEST(SocketcanBus, AKernelWithoutCanIsNamed) {
  FakeKernel kernel;
  kernel.open_error = -EAFNOSUPPORT;
  try {
    const BusSockets sockets({}, kernel);
    FAIL() << "no exception";
  } catch (const std::system_error& error) {
    EXPECT_NE(std::string(error.what()).find("modprobe can-raw"), std::string::npos);
  }
}

TEST(SocketcanBus, SendsAFrameWithOneCall) {
  Rig rig;
  Frame sent = frame(0x105);
  sent.dlc = 3;
  sent.data = {1, 2, 3, 0, 0, 0, 0, 0};
  const unsigned before = rig.kernel.total();
  EXPECT_EQ(rig.bus.send(sent), SendResult::queued);
  EXPECT_EQ(rig.kernel.total(), before + 1);
  ASSERT_EQ(rig.kernel.sent.size(), 1u);
  EXPECT_EQ(rig.kernel.sent[0].can_id, 0x105u);
  EXPECT_EQ(rig.kernel.sent[0].len, 3);
  EXPECT_EQ(rig.kernel.sent[0].data[2], 3);
}

TEST(SocketcanBus, AFullQueueIsCountedAndNotTriedAgain) {
  Rig rig;
  for (const int error : {-ENOBUFS, -EAGAIN}) {
    rig.kernel.send_result = error;
    EXPECT_EQ(rig.bus.send(frame(0x105)), SendResult::queue_full);
  }
  EXPECT_EQ(rig.kernel.calls["send"], 2u);
  EXPECT_EQ(rig.bus.status().queue_full, 2u);
}

TEST(SocketcanBus, AnInterfaceThatGoesWhileSendingIsNoFullQueue) {
  Rig rig;
  for (const int error : {-ENETDOWN, -ENODEV, -ENXIO}) {
    rig.kernel.send_result = error;
    EXPECT_EQ(rig.bus.send(frame(0x105)), SendResult::interface_down);
  }
  EXPECT_EQ(rig.bus.status().queue_full, 0u);
}

TEST(SocketcanBus, WhileNothingCanBeSentTheKernelIsNotAsked) {
  LinkFacts down = can0();
  down.up = false;
  for (const LinkFacts& facts : {LinkFacts{}, down, can0(500'000)}) {
    Rig rig(facts);
    EXPECT_EQ(rig.bus.send(frame(0x105)), SendResult::interface_down);
    EXPECT_EQ(rig.kernel.calls["send"], 0u);
  }
}

TEST(SocketcanBus, AnInterfaceThatReturnsHasASocketOfItsOwn) {
  Rig rig(LinkFacts{});
  EXPECT_EQ(rig.bus.status().link, LinkState::missing);
  EXPECT_TRUE(rig.kernel.bound.empty()) << "a socket bound to no interface receives from all";
  EXPECT_TRUE(rig.next().empty());
  EXPECT_EQ(rig.kernel.calls["recvmmsg"], 0u);

  rig.links.facts = can0();
  rig.watch.look();
  EXPECT_EQ(rig.bus.status().link, LinkState::up);
  EXPECT_EQ(rig.bus.send(frame(0x105)), SendResult::queued);

  rig.links.facts = {};
  rig.watch.look();
  EXPECT_EQ(rig.bus.status().link, LinkState::missing);
  rig.links.facts = can0();
  rig.links.facts.index = 9;   // another device under the same name
  rig.kernel.filters.clear();  // the old one took them along
  rig.watch.look();
  EXPECT_EQ(rig.kernel.sockets, std::set<int>{8});
  const unsigned before = rig.kernel.total();
  EXPECT_EQ(rig.bus.status().link, LinkState::up);
  EXPECT_EQ(rig.kernel.total(), before)
      << "the realtime thread waits for no lock of the network configuration";
  EXPECT_EQ(rig.kernel.bound, (std::vector<int>{5, 9}));
  EXPECT_EQ(rig.kernel.filters.size(), 3u);
  EXPECT_EQ(rig.bus.send(frame(0x105)), SendResult::queued);
}

TEST(SocketcanBus, ASocketIsClosedOnceTheRealtimeThreadHasAnother) {
  Rig rig;
  EXPECT_EQ(rig.kernel.sockets, std::set<int>{7});
  rig.links.facts.index = 9;
  rig.watch.look();
  EXPECT_EQ(rig.kernel.sockets, (std::set<int>{7, 8})) << "it is still used";
  EXPECT_EQ(rig.bus.send(frame(0x105)), SendResult::queued);
  rig.links.facts.index = 10;
  rig.watch.look();
  EXPECT_EQ(rig.kernel.sockets, (std::set<int>{7, 9})) << "nobody has ever used the one between";
  EXPECT_EQ(rig.bus.status().link, LinkState::missing) << "for once, for it was gone";
  EXPECT_EQ(rig.bus.status().link, LinkState::up);
  rig.watch.look();
  EXPECT_EQ(rig.kernel.sockets, std::set<int>{9});
  EXPECT_EQ(rig.bus.send(frame(0x105)), SendResult::queued);
}

TEST(SocketcanBus, OnAnotherAdapterNothingIsSentOrReceived) {
  Rig rig;
  LinkWatch watch{rig.links, rig.board, rig.sockets, {"can0", 1'000'000, false, read_pin("serial=A").pin}};
  rig.links.facts.index = 9;
  watch.look();
  EXPECT_EQ(rig.bus.status().link, LinkState::wrong_adapter);
  rig.arrive(0x105);
  EXPECT_TRUE(rig.next().empty());
  EXPECT_EQ(rig.bus.send(frame(0x105)), SendResult::interface_down);
  EXPECT_EQ(rig.kernel.calls["send"], 0u);
  EXPECT_EQ(rig.kernel.bound, std::vector<int>{5}) << "not bound to it";
}

TEST(SocketcanBus, ABindThatFailsIsTriedAgain) {
  Rig rig(LinkFacts{});
  rig.kernel.bind_result = -ENODEV;
  rig.links.facts = can0();
  rig.watch.look();
  EXPECT_EQ(rig.bus.status().link, LinkState::missing);
  EXPECT_EQ(rig.bus.send(frame(0x105)), SendResult::interface_down);
  rig.kernel.bind_result = 0;
  rig.watch.look();
  EXPECT_EQ(rig.bus.status().link, LinkState::up);
}

TEST(SocketcanBus, OwnFramesAreToldFromOthers) {
  Rig rig;
  rig.arrive(0x303);
  rig.arrive(0x105, Time{0}, true);
  const auto received = rig.next();
  ASSERT_EQ(received.size(), 2u);
  EXPECT_FALSE(received[0].own);
  EXPECT_EQ(received[0].frame.id, 0x303u);
  EXPECT_TRUE(received[1].own);
}

TEST(SocketcanBus, FramesOfOtherSizesAndKindsAreNoTelegrams) {
  Rig rig;
  rig.arrive(0x303);
  rig.kernel.arriving.back().size = 72;  // CAN FD
  rig.arrive(0x303 | CAN_EFF_FLAG);
  rig.arrive(0x303 | CAN_RTR_FLAG);
  const auto received = rig.next();
  ASSERT_EQ(received.size(), 2u);
  EXPECT_TRUE(received[0].frame.extended);
  EXPECT_TRUE(received[1].frame.remote);
}

TEST(SocketcanBus, OneLookAfterEachSleepTakesEverything) {
  Rig rig;
  for (unsigned i = 0; i < 40; ++i) rig.arrive(0x303);
  EXPECT_EQ(rig.next().size(), 40u);
  EXPECT_EQ(rig.kernel.calls["recvmmsg"], 1u);
  EXPECT_TRUE(rig.take().empty());
  EXPECT_EQ(rig.kernel.calls["recvmmsg"], 1u) << "it has just looked";
}

TEST(SocketcanBus, MoreThanABatchIsTakenAfterTheNextSleep) {
  Rig rig;
  for (unsigned i = 0; i < ReceiveBatch::kFrames + 3; ++i) rig.arrive(0x303);
  EXPECT_EQ(rig.next().size(), ReceiveBatch::kFrames);
  EXPECT_EQ(rig.next().size(), 3u);
}

TEST(SocketcanBus, ADeadlineThatHasPassedCostsNoSleep) {
  Rig rig;
  EXPECT_EQ(rig.bus.wait_until(rig.kernel.now), Wake::deadline);
  EXPECT_EQ(rig.kernel.calls["clock_nanosleep"], 0u);
  rig.kernel.interrupt = true;
  EXPECT_EQ(rig.bus.wait_until(rig.kernel.now + milliseconds(1)), Wake::interrupted);
}

TEST(SocketcanBus, WakesForFramesWhenToldSo) {
  Rig rig(can0(), true);
  const Time deadline = rig.kernel.now + milliseconds(1);
  rig.arrive(0x303);
  EXPECT_EQ(rig.bus.wait_until(deadline), Wake::frame);
  EXPECT_EQ(rig.take().size(), 1u);
  EXPECT_EQ(rig.bus.wait_until(deadline), Wake::deadline);
  EXPECT_EQ(rig.bus.now(), deadline);
  EXPECT_EQ(rig.kernel.calls["ppoll"], 2u);
}

TEST(SocketcanBus, WaitsForAFrameWhereItWouldSleepOn) {
  Rig rig;
  const Time deadline = rig.kernel.now + milliseconds(1);
  rig.arrive(0x303);
  EXPECT_EQ(rig.bus.wait_for_frame(deadline), Wake::frame);
  EXPECT_LT(rig.bus.now(), deadline);
  EXPECT_EQ(rig.take().size(), 1u);
  rig.arrive(0x303);
  EXPECT_EQ(rig.bus.wait_until(deadline), Wake::deadline);
  EXPECT_EQ(rig.bus.now(), deadline);
}

TEST(SocketcanBus, WithoutAnInterfaceItSleepsToTheDeadline) {
  Rig rig(LinkFacts{}, true);
  EXPECT_EQ(rig.bus.wait_until(rig.kernel.now + milliseconds(1)), Wake::deadline);
  EXPECT_EQ(rig.kernel.calls["ppoll"], 0u) << "the socket would be ready at once, with its error";
}

TEST(SocketcanBus, DropsOfTheKernelAreCounted) {
  Rig rig;
  rig.arrive(0x303);
  rig.kernel.arriving.back().drops = 4;
  rig.arrive(0x303);
  rig.kernel.arriving.back().drops = 4;
  rig.next();
  EXPECT_EQ(rig.bus.status().dropped, 4u);
  rig.arrive(0x303);
  rig.kernel.arriving.back().drops = 9;
  rig.next();
  EXPECT_EQ(rig.bus.status().dropped, 9u);
}

TEST(SocketcanBus, ErrorFramesMakeTheControllersState) {
  Rig rig;
  const auto state = [&](std::uint32_t kind, std::uint8_t controller) {
    rig.arrive_error(kind, controller);
    EXPECT_TRUE(rig.next().empty()) << "error frames are not handed out";
    return rig.bus.status().state;
  };
  EXPECT_EQ(state(CAN_ERR_CRTL, CAN_ERR_CRTL_TX_WARNING), ControllerState::error_warning);
  EXPECT_EQ(state(CAN_ERR_CRTL, CAN_ERR_CRTL_RX_PASSIVE), ControllerState::error_passive);
  EXPECT_EQ(state(CAN_ERR_CRTL, CAN_ERR_CRTL_ACTIVE), ControllerState::error_active);
  EXPECT_EQ(state(CAN_ERR_BUSOFF, 0), ControllerState::bus_off);
  EXPECT_EQ(rig.bus.send(frame(0x105)), SendResult::bus_off);
  EXPECT_EQ(rig.kernel.calls["send"], 0u);
  EXPECT_EQ(state(CAN_ERR_RESTARTED, 0), ControllerState::error_active);
  EXPECT_EQ(rig.bus.status().restarts, 1u);
  EXPECT_EQ(rig.bus.status().error_frames, 5u);
  EXPECT_EQ(rig.bus.send(frame(0x105)), SendResult::queued);
}

TEST(SocketcanBus, WhatTheDriverWasAskedBeforeAnErrorFrameIsOutOfDate) {
  Rig rig;
  rig.links.facts.state = ControllerState::error_passive;
  rig.links.facts.has_counters = true;
  rig.links.facts.transmit_errors = 130;
  rig.watch.look();
  EXPECT_EQ(rig.bus.status().state, ControllerState::error_passive);
  EXPECT_EQ(rig.bus.status().transmit_errors, 130);
  rig.arrive_error(CAN_ERR_BUSOFF);
  rig.next();
  EXPECT_EQ(rig.bus.status().state, ControllerState::bus_off);
  rig.links.facts.state = ControllerState::error_active;  // the kernel has restarted it, without a word
  rig.watch.look();
  EXPECT_EQ(rig.bus.status().state, ControllerState::error_active);
}

TEST(SocketcanBus, MissingAcknowledgementsAndOverrunsAreCounted) {
  Rig rig;
  rig.arrive_error(CAN_ERR_ACK);
  rig.arrive_error(CAN_ERR_PROT);
  rig.kernel.arriving.back().frame.data[3] = CAN_ERR_PROT_LOC_ACK;
  rig.arrive_error(CAN_ERR_CRTL, CAN_ERR_CRTL_RX_OVERFLOW);
  rig.arrive_error(CAN_ERR_CNT);
  rig.kernel.arriving.back().frame.data[6] = 17;
  rig.kernel.arriving.back().frame.data[7] = 3;
  rig.arrive_error(CAN_ERR_ACK);
  rig.board.begin_era();  // what the driver was asked is older
  rig.next();
  const ControllerStatus status = rig.bus.status();
  EXPECT_EQ(status.acknowledge_errors, 3u);
  EXPECT_EQ(status.overruns, 1u);
  EXPECT_EQ(status.error_frames, 5u);
  EXPECT_EQ(status.transmit_errors, 17);
  EXPECT_EQ(status.receive_errors, 3);
  EXPECT_EQ(status.state, ControllerState::error_active);
}

TEST(SocketcanBus, AResetIsLeftToTheWatchAndAnsweredOnce) {
  Rig rig;
  rig.links.facts.state = ControllerState::bus_off;
  EXPECT_EQ(rig.bus.reset(), ResetResult::pending);
  EXPECT_EQ(rig.bus.reset(), ResetResult::pending);
  EXPECT_EQ(rig.links.interrupts, 1u) << "the same one";
  EXPECT_EQ(rig.bus.reset_result(), ResetResult::pending);
  EXPECT_TRUE(rig.links.asked.empty());
  rig.watch.look();
  EXPECT_EQ(rig.bus.reset_result(), ResetResult::done);
  EXPECT_EQ(rig.links.asked, std::vector<std::string>{"restart 5"});
  rig.watch.look();
  EXPECT_EQ(rig.links.asked.size(), 1u);
  EXPECT_EQ(rig.bus.status().state, ControllerState::error_active);
}

}  // namespace
}  // namespace can::test
