// SFB 403 CAN_CFG, 404 CAN_STAT, 410 CAN_RXQ, 411 CAN_TXQ and 412 CAN_CFGQ, sections 4.2.1 and 4.2.3 of the
// manual of the Saia PCD's CAN functions: each row of their tables of inputs, outputs and codes.
#include <cansync/function_blocks/layer2/can_status.h>

#include <array>

#include "frame_rig.h"

namespace cansync::client::function_blocks {
namespace {

class BasicServices : public FrameBlockTest {
 protected:
  void SetUp() override {
    configure.Baudrate = 500'000;
    queues.RxQueueDepth = queues.TxQueueDepth = 4;
    send.TxData = bytes;
    receive.RxData = target;
  }
  /// Both are set up.
  void begin() {
    ASSERT_TRUE(call_until(configure, [&] { return configure.RetVal == can_status::done; }))
        << configure.error();
    queues.call();
    ASSERT_EQ(queues.RetVal, can_status::done) << queues.error();
  }
  WORD configured(INT time_segment, DINT bit_rate) {
    configure.TimeSeg1 = time_segment;
    configure.Baudrate = bit_rate;
    configure.call();
    return configure.RetVal;
  }
  WORD entered(DWORD identifier, BOOL priority = false) {
    send.MsgID = identifier;
    send.DLC = 2;
    send.Priority = priority;
    send.call();
    EXPECT_EQ(send.Error, send.Status != 0);
    return send.Status;
  }
  std::vector<std::uint32_t> sent() const {
    std::vector<std::uint32_t> identifiers;
    for (const auto& one : daemon->sends) identifiers.push_back(one.content.identifier);
    return identifiers;
  }

  CAN_CFG configure{connection};
  CAN_CFGQ queues{connection};
  CAN_TXQ send{connection};
  CAN_RXQ receive{connection};
  CAN_STAT state{connection};
  std::array<BYTE, 8> bytes = {1, 2, 3, 4, 5, 6, 7, 8};
  std::array<BYTE, 8> target = {};
};

// The two tables of bit timings: any other value is 8190; the first is not for 1 Mbit/s.
TEST_F(BasicServices, L31EachBitTimingOfTheTables) {
  begin();
  for (INT number = 0; number < 300; ++number) {
    const bool first = number >= 7 && number <= 14;
    const bool second = number >= 258 && number <= 262;
    EXPECT_EQ(configured(number, 500'000), first || second ? can_status::done : can_status::wrong_parameter)
        << number;
    // A possible one comes as far as the comparison with the daemon's bit rate.
    EXPECT_EQ(configured(number, 1'000'000), second ? can_status::refused : can_status::wrong_parameter)
        << number;
  }
}

TEST_F(BasicServices, L31EachBitRateOfTheTableComparedWithTheDaemons) {
  begin();
  for (const DINT rate : {10'000, 20'000, 50'000, 100'000, 125'000, 250'000}) {
    EXPECT_EQ(configured(8, rate), can_status::refused) << rate;
    EXPECT_NE(configure.error().find("bus.bit_rate"), std::string::npos) << configure.error();
  }
  for (const DINT rate : {0, -1, 9'600, 800'000, 2'000'000})
    EXPECT_EQ(configured(8, rate), can_status::wrong_bit_rate);
  EXPECT_EQ(configured(8, 500'000), can_status::done);
}

TEST_F(BasicServices, L31PortAndRoutines) {
  begin();
  configure.PortID = 8;
  EXPECT_EQ(configured(8, 500'000), can_status::wrong_port);
  configure.PortID = 0;
  for (const INT routine : {INT{39}, INT{48}, INT{-1}}) {
    configure.RxIntOB = routine;
    EXPECT_EQ(configured(8, 500'000), can_status::wrong_parameter);
    configure.RxIntOB = 40;
    configure.TxIntOB = routine;
    EXPECT_EQ(configured(8, 500'000), can_status::wrong_parameter);
    configure.TxIntOB = 47;
    EXPECT_EQ(configured(8, 500'000), can_status::done);
  }
}

// "All earlier settings and all configurations made with SFB 402 and SFB 412 are deleted".
TEST_F(BasicServices, L31BeginsAnew) {
  begin();
  EXPECT_EQ(entered(0x100), can_status::done);
  configure.call();
  EXPECT_EQ(entered(0x100), can_status::no_queue);
  receive.call();
  EXPECT_EQ(receive.Status, can_status::no_queue);
}

TEST_F(BasicServices, L32StateOfTheController) {
  daemon->bus.receive_errors = 95;
  daemon->bus.transmit_errors = 7;
  daemon->tell();
  ASSERT_TRUE(call_until(state, [&] { return state.RxErrCtr == 95; }));
  EXPECT_EQ(state.RetVal, can_status::done);
  EXPECT_EQ(state.TxErrCtr, 7);
  EXPECT_FALSE(state.BusOff || state.Warning || state.ErrorState || state.Error);
  daemon->bus.receive_errors = 96;
  daemon->bus.error_frames = 1;
  daemon->tell();
  bool error = false;
  ASSERT_TRUE(call_until(state, [&] {
    error = error || state.Error;
    return BOOL{state.Warning};
  }));
  EXPECT_TRUE(error);
  EXPECT_FALSE(state.ErrorState);
  state.call();
  EXPECT_FALSE(state.Error) << "none came since";
  daemon->bus.transmit_errors = 128;
  daemon->tell();
  ASSERT_TRUE(call_until(state, [&] { return BOOL{state.ErrorState}; }));
  gateway::dds::copy_text("bus-off", daemon->bus.controller_state);
  daemon->bus.transmit_errors = 300;
  daemon->tell();
  ASSERT_TRUE(call_until(state, [&] { return BOOL{state.BusOff}; }));
  EXPECT_EQ(state.TxErrCtr, 255);
  state.PortID = 1;
  state.call();
  EXPECT_EQ(state.RetVal, can_status::wrong_port);
}

TEST_F(BasicServices, L45EachInputOfTheQueues) {
  queues.call();
  EXPECT_EQ(queues.RetVal, can_status::refused) << "CAN_CFG comes first";
  begin();
  const auto retval = [&](auto& input, auto value) {
    const auto before = std::exchange(input, value);
    queues.call();
    input = before;
    return queues.RetVal;
  };
  EXPECT_EQ(retval(queues.PortID, INT{1}), can_status::wrong_port);
  EXPECT_EQ(retval(queues.RxQueueDepth, INT{0}), can_status::wrong_parameter);
  EXPECT_EQ(retval(queues.TxQueueDepth, INT{-1}), can_status::wrong_parameter);
  EXPECT_EQ(retval(queues.RxQueueDepth, INT{1001}), can_status::no_memory);
  EXPECT_EQ(retval(queues.TxQueueDepth, INT{1000}), can_status::done);
  EXPECT_EQ(retval(queues.MsgID, DWORD{0x800}), can_status::wrong_parameter);
  EXPECT_EQ(retval(queues.RxEnableInt, true), can_status::wrong_parameter) << "routine 0";
  queues.TxIntOB = 48;
  EXPECT_EQ(retval(queues.TxEnableInt, false), can_status::done) << "not enabled, not looked at";
  EXPECT_EQ(retval(queues.TxEnableInt, true), can_status::wrong_parameter);
  queues.IDE = true;
  EXPECT_EQ(retval(queues.MsgID, DWORD{0x1FFFFFFF}), can_status::done);
}

// "accept if (received XOR configured) AND mask = 0": the manual's example.
TEST_F(BasicServices, L45TheMaskSaysWhatComes) {
  queues.MsgID = 0x137;
  queues.Mask = 0x7EC;
  queues.RxQueueDepth = 100;
  begin();
  std::vector<layer2_ReceivedFrame> frames;
  for (std::uint32_t identifier = 0x120; identifier < 0x140; ++identifier)
    frames.push_back(FakeFrameDaemon::frame(identifier, {1}));
  auto wide = FakeFrameDaemon::frame(0x137, {1});
  wide.received.extended = true;
  auto remote = FakeFrameDaemon::frame(0x137, {});
  remote.received.remote = true;
  frames.insert(frames.end(), {wide, remote, FakeFrameDaemon::frame(0x137, {0xFF})});
  daemon->came(frames);
  std::vector<DWORD> taken;
  ASSERT_TRUE(call_until(receive, [&] {
    if (receive.NDR) taken.push_back(receive.MsgID);
    return receive.NDR && target[0] == 0xFF;
  }));
  EXPECT_EQ(taken, (std::vector<DWORD>{0x124, 0x125, 0x126, 0x127, 0x134, 0x135, 0x136, 0x137, 0x137}));
}

TEST_F(BasicServices, L46AFullSendQueueDropsTheNewOne) {
  begin();
  daemon->answers = false;
  for (DWORD identifier = 1; identifier <= 4; ++identifier) EXPECT_EQ(entered(identifier), can_status::done);
  EXPECT_EQ(entered(5), can_status::full);
  EXPECT_NE(send.error().find("full"), std::string::npos);
  ASSERT_TRUE(call_until(receive, [&] { return daemon->sends.size() == 4; }));
  EXPECT_EQ(entered(5), can_status::full) << "those that the daemon has count";
  daemon->reply(daemon->sends[0], gateway_REPLY_DONE);
  ASSERT_TRUE(call_until(receive, [&] { return entered(6) == can_status::done; }));
  ASSERT_TRUE(call_until(receive, [&] { return daemon->sends.size() == 5; }));
  EXPECT_EQ(sent(), (std::vector<std::uint32_t>{1, 2, 3, 4, 6}));
}

TEST_F(BasicServices, L47PriorityGoesInFrontOfHigherIdentifiersSecondAtBest) {
  queues.TxQueueDepth = 200;
  begin();
  daemon->answers = false;
  for (DWORD i = 0; i < 40; ++i) EXPECT_EQ(entered(0x400), can_status::done);
  ASSERT_TRUE(call_until(receive, [&] { return daemon->sends.size() == 40; })) << "what the daemon has";
  EXPECT_EQ(entered(0x500), can_status::done);
  EXPECT_EQ(entered(0x300), can_status::done);
  EXPECT_EQ(entered(0x500, true), can_status::done) << "behind its equal, in front of nothing";
  EXPECT_EQ(entered(0x200, true), can_status::done);
  for (const auto& one : std::vector(daemon->sends)) daemon->reply(one, gateway_REPLY_DONE);
  daemon->answers = true;
  ASSERT_TRUE(call_until(receive, [&] { return daemon->sends.size() == 44; }));
  auto order = sent();
  order.erase(order.begin(), order.begin() + 40);
  EXPECT_EQ(order, (std::vector<std::uint32_t>{0x200, 0x500, 0x300, 0x500}));
  EXPECT_TRUE(daemon->sends[40].by_identifier) << "the daemon's own queue does the same";
  EXPECT_FALSE(daemon->sends[41].by_identifier);
}

// Each row of CAN_TXQ's table but "queue full".
TEST_F(BasicServices, L60StatusOfCanTxq) {
  EXPECT_EQ(entered(1), can_status::no_queue);
  begin();
  send.PortID = 1;
  EXPECT_EQ(entered(1), can_status::wrong_port);
  send.PortID = 0;
  for (const INT length : {INT{-1}, INT{9}}) {
    send.DLC = length;
    send.call();
    EXPECT_EQ(send.Status, can_status::wrong_length);
  }
  send.TxData = std::span(bytes).first(1);
  EXPECT_EQ(entered(1), can_status::wrong_length) << "two bytes of one";
  send.TxData = bytes;
  EXPECT_EQ(entered(0x800), can_status::refused);
  daemon->status.running = false;
  daemon->tell();
  ASSERT_TRUE(call_until(receive, [&] { return entered(1) == can_status::refused; }));
  EXPECT_NE(send.error().find("stop"), std::string::npos) << send.error();
}

TEST_F(BasicServices, L60StatusOfCanRxq) {
  receive.call();
  EXPECT_EQ(receive.Status, can_status::no_queue);
  EXPECT_TRUE(receive.Error);
  begin();
  receive.call();
  EXPECT_EQ(receive.Status, can_status::done);
  EXPECT_FALSE(receive.NDR || receive.Error);
  receive.PortID = -1;
  receive.call();
  EXPECT_EQ(receive.Status, can_status::wrong_port);
  receive.PortID = 0;
  receive.RxData = std::span(target).first(7);
  receive.call();
  EXPECT_EQ(receive.Status, can_status::wrong_identifier) << "8 bytes at least";
  receive.RxData = target;
  daemon->came({FakeFrameDaemon::frame(0x111, {9, 8, 7})});
  ASSERT_TRUE(call_until(receive, [&] { return BOOL{receive.NDR}; }));
  EXPECT_EQ(receive.Status, can_status::done);
  EXPECT_EQ(receive.MsgID, 0x111u);
  EXPECT_EQ(receive.DLC, 3);
  EXPECT_EQ(target, (std::array<BYTE, 8>{9, 8, 7, 0, 0, 0, 0, 0}));
  daemon.reset();
  ASSERT_TRUE(repeat_until([&] { receive.call(); }, [&] { return receive.Status == can_status::refused; }));
}

// "a message arriving at a full queue is discarded and the error shows exactly once, in the next call".
TEST_F(BasicServices, L48AnOverrunIsToldOnceWithTheOldestFrame) {
  begin();
  std::vector<layer2_ReceivedFrame> frames;
  for (std::uint8_t i = 1; i <= 6; ++i) frames.push_back(FakeFrameDaemon::frame(i, {i}));
  daemon->came(frames);
  ASSERT_TRUE(call_until(receive, [&] { return BOOL{receive.NDR}; }));
  EXPECT_TRUE(receive.Error);
  EXPECT_EQ(receive.Status, can_status::full);
  EXPECT_EQ(receive.MsgID, 1u);
  for (DWORD next = 2; next <= 4; ++next) {
    receive.call();
    EXPECT_TRUE(receive.NDR);
    EXPECT_EQ(receive.Status, can_status::done);
    EXPECT_EQ(receive.MsgID, next);
  }
  receive.call();
  EXPECT_FALSE(receive.NDR) << "5 and 6 were discarded";
}

// "event: message entered an empty receive queue", "transmit queue became empty (last message sent
// successfully)"; the routine is told parameter, object and port.
TEST_F(BasicServices, L49EventsOfTheQueues) {
  std::vector<Interrupt> received;
  std::vector<Interrupt> emptied;
  connection.on_interrupt(40, [&](const Interrupt& one) { received.push_back(one); });
  connection.on_interrupt(47, [&](const Interrupt& one) { emptied.push_back(one); });
  queues.RxIntOB = 40;
  queues.RxIntPrm = 0x1234;
  queues.TxIntOB = 47;
  queues.TxIntPrm = 0x4321;
  queues.RxEnableInt = queues.TxEnableInt = true;
  begin();
  daemon->came({FakeFrameDaemon::frame(1, {1}), FakeFrameDaemon::frame(2, {1})});
  ASSERT_TRUE(call_until(state, [&] { return !received.empty(); }));
  EXPECT_EQ(received.size(), 1u) << "the second came to a queue that was not empty";
  EXPECT_EQ(received[0].parameter, 0x1234);
  EXPECT_EQ(received[0].object, 30);
  EXPECT_EQ(received[0].port, 0);
  receive.call();
  receive.call();
  daemon->came({FakeFrameDaemon::frame(3, {1})});
  ASSERT_TRUE(call_until(state, [&] { return received.size() == 2; }));
  daemon->answers = false;
  EXPECT_EQ(entered(1), can_status::done);
  EXPECT_EQ(entered(2), can_status::done);
  ASSERT_TRUE(call_until(state, [&] { return daemon->sends.size() == 2; }));
  daemon->reply(daemon->sends[0], gateway_REPLY_DONE);
  daemon->reply(daemon->sends[1], gateway_REPLY_DONE);
  ASSERT_TRUE(call_until(state, [&] { return !emptied.empty(); }));
  EXPECT_EQ(emptied.size(), 1u);
  EXPECT_EQ(emptied[0].parameter, 0x4321);
  EXPECT_EQ(emptied[0].object, 31);
  EXPECT_EQ(entered(3), can_status::done);
  ASSERT_TRUE(call_until(state, [&] { return daemon->sends.size() == 3; }));
  daemon->reply(daemon->sends[2], gateway_REPLY_TIMEOUT, "bus-off");
  ASSERT_TRUE(
      call_until(state, [&] { return entered(4) == can_status::done && send.error() == "daemon: bus-off"; }));
  EXPECT_EQ(emptied.size(), 1u) << "it was not sent successfully";
}

}  // namespace
}  // namespace cansync::client::function_blocks
