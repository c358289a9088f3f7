// FC 65 CANSEND, FC 66 CANRCV and FC 67 CANCTRL, sections 7.2.2 to 7.2.5 of the manual of the CAN 300 PRO
// (edition 3), and RETVAL of 8.
#include <cansync/function_blocks/module_codes.h>

#include "frame_rig.h"

namespace cansync::client::function_blocks {
namespace {

constexpr WORD kRuns = 0x0100;
constexpr WORD kIsModule = 0x4000;
constexpr WORD kSendEmpty = 0x0010;
constexpr WORD kSendOverflow = 0x0040;
constexpr WORD kSendHighHalf = 0x0080;
constexpr WORD kReceiveEmpty = 0x0001;
constexpr WORD kReceiveOverflow = 0x0004;
constexpr WORD kReceiveHighHalf = 0x0008;

class Cansend : public FrameBlockTest {
 protected:
  void send_until(CANSEND& block, std::size_t count) {
    block.Snd = true;
    ASSERT_TRUE(call_until(block, [&] { return daemon->sends.size() >= count; })) << block.error();
  }
};

// "The word RTRLEN contains the number of data bytes (0..8) in the lower 4 bits (bit 0 to bit 3)."
TEST_F(Cansend, L16EveryInputStandsInTheFrame) {
  CANSEND block(connection);
  block.IDLO = 0x202;
  block.RTRLEN = 5;
  block.DW0 = 0x0102;
  block.DW1 = 0x0304;
  block.DW2 = 0x0506;
  block.DW3 = 0x0708;
  send_until(block, 1);
  const layer2_CanFrame& frame = daemon->sends[0].content;
  EXPECT_EQ(frame.identifier, 0x202u);
  EXPECT_FALSE(frame.extended);
  EXPECT_FALSE(frame.remote);
  EXPECT_EQ(frame.length, 5);
  EXPECT_EQ(std::vector(frame.data, frame.data + 8), (std::vector<std::uint8_t>{1, 2, 3, 4, 5, 0, 0, 0}));
  EXPECT_FALSE(daemon->sends[0].high_priority);
  EXPECT_FALSE(block.Snd) << "reset once the frame has been transferred to the module";
}

// "Bit 6 is the RTR bit of the CAN frame. Setting bit 7 transmits the frame as a high-priority message."
TEST_F(Cansend, L16BitsOfRtrlen) {
  CANSEND block(connection, IdentifierWidth::bits_29);
  block.IDHI = 0x18FE;
  block.IDLO = 0xF121;
  block.RTRLEN = 0xC3;
  block.DW0 = 0xFFFF;
  send_until(block, 1);
  const layer2_CanFrame& frame = daemon->sends[0].content;
  EXPECT_EQ(frame.identifier, 0x18FEF121u);
  EXPECT_TRUE(frame.extended);
  EXPECT_TRUE(frame.remote);
  EXPECT_EQ(frame.length, 3);
  EXPECT_EQ(frame.data[0], 0) << "a remote frame has no data";
  EXPECT_TRUE(daemon->sends[0].high_priority);
}

// "If the transmit buffer in the module is full, older frames that have not been transmitted yet are
// deleted."
TEST_F(Cansend, L16AFullBufferOfHighPriorityDeletesTheOldest) {
  CANSEND block(connection);
  daemon->answers = false;
  const auto enter = [&](unsigned number) {
    block.DW0 = static_cast<WORD>(number);
    block.RTRLEN = 0x82;
    block.Snd = true;
    block.call();
    EXPECT_FALSE(block.Snd);
    EXPECT_EQ(block.RETVAL, module_code::done);
  };
  for (unsigned i = 0; i < 40; ++i) enter(i);
  ASSERT_TRUE(call_until(block, [&] { return daemon->sends.size() == 40; }))
      << "what the daemon takes at a time";
  for (unsigned i = 40; i < 49; ++i) enter(i);
  EXPECT_EQ(block.STAT & kSendHighHalf, 0);
  enter(49);
  EXPECT_NE(block.STAT & kSendHighHalf, 0) << "10 of 20";
  for (unsigned i = 50; i < 60; ++i) enter(i);
  EXPECT_EQ(block.STAT & kSendOverflow, 0);
  enter(60);
  EXPECT_NE(block.STAT & kSendOverflow, 0);
  EXPECT_EQ(block.STAT & kSendEmpty, 0);
  const auto held = daemon->sends;
  for (const auto& one : held) daemon->reply(one, gateway_REPLY_DONE);
  daemon->answers = true;
  ASSERT_TRUE(call_until(block, [&] { return (block.STAT & kSendEmpty) != 0; }));
  ASSERT_EQ(daemon->sends.size(), 60u);
  EXPECT_EQ(daemon->sends[40].content.data[1], 41) << "number 40 is gone";
}

TEST_F(Cansend, L16HighPriorityOvertakesWhatWaits) {
  CANSEND block(connection);
  daemon->answers = false;
  for (unsigned i = 0; i < 45; ++i) {
    block.DW0 = static_cast<WORD>(i);
    block.RTRLEN = i == 44 ? 0x82 : 2;
    block.Snd = true;
    block.call();
  }
  ASSERT_TRUE(call_until(block, [&] { return daemon->sends.size() == 40; }));
  daemon->reply(daemon->sends[0], gateway_REPLY_DONE);
  ASSERT_TRUE(call_until(block, [&] { return daemon->sends.size() == 41; }));
  EXPECT_EQ(daemon->sends[40].content.data[1], 44);
}

// "The parameter is always assigned value, even if the Snd bit is not set."
TEST_F(Cansend, L16StatIsThereWithEveryCall) {
  CANSEND block(connection);
  block.call();
  EXPECT_EQ(block.STAT, kIsModule | kRuns | kSendEmpty | kReceiveEmpty);
  daemon->status.send_overflowed = daemon->status.receive_overflowed = true;
  daemon->status.send_high_depth = 20;
  daemon->status.send_high_waiting = 10;
  daemon->tell();
  EXPECT_TRUE(call_until(block, [&] { return (block.STAT & kSendOverflow) != 0; }))
      << "of the daemon's queues";
  EXPECT_NE(block.STAT & kReceiveOverflow, 0);
  EXPECT_NE(block.STAT & kSendHighHalf, 0);
}

// The codes of section 8 that a block of layer 2 can have: 80F1 "Module not ready", 82E2 for inputs.
TEST_F(Cansend, L27RetvalSaysWhyNothingIsSent) {
  CANSEND block(connection);
  const auto refused = [&](INT code, const char* word) {
    block.Snd = true;
    block.call();
    EXPECT_EQ(block.RETVAL, code);
    EXPECT_TRUE(block.Snd) << "it was not taken";
    EXPECT_NE(block.error().find(word), std::string::npos) << block.error();
  };
  block.IDLO = 0x800;
  refused(static_cast<INT>(0x82E2), "0..0x7FF");
  block.IDLO = 0x7FF;
  block.RTRLEN = 9;
  refused(static_cast<INT>(0x82E2), "0..8");
  block.RTRLEN = 8;
  block.Snd = false;
  daemon->status.running = false;
  daemon->tell();
  ASSERT_TRUE(call_until(block, [&] { return (block.STAT & kRuns) == 0; }));
  refused(static_cast<INT>(0x80F1), "stop");
  daemon->status.running = true;
  daemon->tell();
  ASSERT_TRUE(call_until(block, [&] { return !daemon->sends.empty(); })) << "Snd was still TRUE";
  EXPECT_EQ(block.RETVAL, module_code::done);
  EXPECT_EQ(daemon->sends.size(), 1u);
}

TEST_F(Cansend, L27AFrameThatFailsIsTold) {
  CANSEND block(connection);
  daemon->answers = false;
  send_until(block, 1);
  daemon->reply(daemon->sends[0], gateway_REPLY_NO_ANSWER, "its echo was not seen");
  ASSERT_TRUE(call_until(block, [&] { return block.failures() == 1; }));
  EXPECT_EQ(block.error(), "daemon: its echo was not seen");
}

TEST_F(Cansend, L27AfterARestartTheFirstFrameIsRefused) {
  CANSEND block(connection);
  send_until(block, 1);
  daemon.reset();
  daemon.emplace(places.here);
  bool refused = false;
  ASSERT_TRUE(repeat_until(
      [&] {
        block.Snd = true;
        block.call();
        refused = refused || block.error().find("started anew") != std::string::npos;
        daemon->take();
      },
      [&] { return !daemon->sends.empty(); }));
  EXPECT_TRUE(refused);
}

// A request that nobody is known to read reaches nobody.
TEST_F(Cansend, L27AFrameWaitsUntilTheNewDaemonIsKnownToReadFrames) {
  CANSEND block(connection);
  restart_unread(block);
  daemon->read_sends();
  EXPECT_TRUE(call_until(block, [&] { return daemon->sends.size() == 1; })) << block.error();
  EXPECT_EQ(block.failures(), 0u);
}

class Canrcv : public FrameBlockTest {};

// "If the function block has read a frame from the CAN 300 PRO module, bit Rcvd is set."
TEST_F(Canrcv, L17GivesOneFrameACallWithEveryOutput) {
  CANRCV block(connection);
  auto remote = FakeFrameDaemon::frame(0x123, {});
  remote.received.remote = true;
  remote.received.length = 4;
  daemon->came({FakeFrameDaemon::frame(0x7FF, {1, 2, 3, 4, 5}), remote});
  ASSERT_TRUE(call_until(block, [&] { return BOOL{block.Rcvd}; }));
  EXPECT_EQ(block.IDHI, 0);
  EXPECT_EQ(block.IDLO, 0x7FF);
  EXPECT_EQ(block.RTRLEN, 5);
  EXPECT_EQ((std::array{block.DW0, block.DW1, block.DW2, block.DW3}),
            (std::array<WORD, 4>{0x0102, 0x0304, 0x0500, 0}));
  block.call();
  EXPECT_TRUE(block.Rcvd);
  EXPECT_EQ(block.IDLO, 0x123);
  EXPECT_EQ(block.RTRLEN, 0x44);
  block.call();
  EXPECT_FALSE(block.Rcvd);
  EXPECT_EQ(block.IDLO, 0x123) << "changes with a frame only";
}

// "If bit 7 is set, the message went via high-priority FIFOs." Those come first (6.3.3).
TEST_F(Canrcv, L17HighPriorityComesFirst) {
  CANRCV block(connection);
  auto high = FakeFrameDaemon::frame(0x200, {1});
  high.high_priority = true;
  daemon->came({FakeFrameDaemon::frame(0x100, {2}), high});
  ASSERT_TRUE(call_until(block, [&] { return BOOL{block.Rcvd}; }));
  EXPECT_EQ(block.IDLO, 0x200);
  EXPECT_EQ(block.RTRLEN, 0x81);
  block.call();
  EXPECT_EQ(block.IDLO, 0x100);
  EXPECT_EQ(block.RTRLEN, 1);
}

TEST_F(Canrcv, L17TheOtherWidthIsPassedOver) {
  CANRCV block(connection, IdentifierWidth::bits_29);
  auto wide = FakeFrameDaemon::frame(0x18FEF121, {7});
  wide.received.extended = true;
  daemon->came({FakeFrameDaemon::frame(0x100, {2}), wide});
  ASSERT_TRUE(call_until(block, [&] { return BOOL{block.Rcvd}; }));
  EXPECT_EQ(block.IDHI, 0x18FE);
  EXPECT_EQ(block.IDLO, 0xF121);
}

// "The parameter is always assigned a value even if no frame has been received."
TEST_F(Canrcv, L17StatSaysHowFullTheBufferIs) {
  CANRCV block(connection);
  CANSEND other(connection);  // takes what comes, and reads nothing
  auto high = FakeFrameDaemon::frame(0x200, {1});
  high.high_priority = true;
  daemon->came(std::vector(9, high));
  ASSERT_TRUE(call_until(other, [&] { return (other.STAT & kReceiveEmpty) == 0; }));
  EXPECT_EQ(other.STAT & kReceiveHighHalf, 0);
  daemon->came({high});
  ASSERT_TRUE(call_until(other, [&] { return (other.STAT & kReceiveHighHalf) != 0; }));
  daemon->came(std::vector(11, high));
  ASSERT_TRUE(call_until(other, [&] { return (other.STAT & kReceiveOverflow) != 0; }));
  daemon.reset();
  ASSERT_TRUE(repeat_until([&] { block.call(); }, [&] { return block.RETVAL == static_cast<INT>(0x80F1); }));
  EXPECT_TRUE(block.Rcvd) << "what waits is given all the same";
}

TEST_F(Canrcv, L17FramesLostOnTheWayAreAnOverflow) {
  CANRCV block(connection);
  daemon->came({FakeFrameDaemon::frame(1, {})});
  daemon->came({FakeFrameDaemon::frame(2, {})}, 1);
  ASSERT_TRUE(call_until(block, [&] { return block.IDLO == 2; }));
  EXPECT_NE(block.STAT & kReceiveOverflow, 0);
  CANCTRL control(connection);
  control.Func = 7;
  control.call();
  EXPECT_EQ(control.STAT & kReceiveOverflow, 0);
}

class Canctrl : public FrameBlockTest {
 protected:
  CANCTRL block{connection};
  layer2_ControlRequest asked(INT function, INT parameter) {
    block.Func = function;
    block.Param = parameter;
    const std::size_t before = daemon->controls.size();
    block.call();
    EXPECT_EQ(block.RETVAL, module_code::done) << block.error();
    CANSEND other(connection);
    EXPECT_TRUE(call_until(other, [&] { return daemon->controls.size() > before && block.open() == 0; }));
    return daemon->controls.empty() ? layer2_ControlRequest{} : daemon->controls.back();
  }
};

TEST_F(Canctrl, L18Function1StartsATimer) {
  EXPECT_EQ(asked(1, 1).kind, layer2_CONTROL_START_TIMER);
  EXPECT_EQ(asked(1, 16).number, 16);
}

TEST_F(Canctrl, L19Function2StopsATimer) {
  const auto request = asked(2, 3);
  EXPECT_EQ(request.kind, layer2_CONTROL_STOP_TIMER);
  EXPECT_EQ(request.number, 3);
}

TEST_F(Canctrl, L20Function5ResetsTheController) {
  EXPECT_EQ(asked(5, 99).kind, layer2_CONTROL_RESET_CONTROLLER);
}

TEST_F(Canctrl, L21Function6EmptiesEveryQueue) {
  CANRCV receive(connection);
  CANSEND send(connection);
  daemon->came({FakeFrameDaemon::frame(1, {}), FakeFrameDaemon::frame(2, {})});
  ASSERT_TRUE(call_until(receive, [&] { return BOOL{receive.Rcvd}; }));
  daemon->answers = false;
  for (int i = 0; i < 45; ++i) {
    send.Snd = true;
    send.call();
  }
  ASSERT_TRUE(call_until(send, [&] { return daemon->sends.size() == 40; }));
  daemon->answers = true;
  EXPECT_EQ(asked(6, 0).kind, layer2_CONTROL_CLEAR_QUEUES);
  receive.call();
  EXPECT_FALSE(receive.Rcvd);
  for (const auto& one : std::vector(daemon->sends)) daemon->reply(one, gateway_REPLY_CANCELLED);
  ASSERT_TRUE(call_until(send, [&] { return (send.STAT & kSendEmpty) != 0; }));
  EXPECT_EQ(daemon->sends.size(), 40u) << "the five that waited here are gone";
}

TEST_F(Canctrl, L22Function7ResetsTheOverflowBits) {
  CANRCV receive(connection);
  daemon->came(std::vector(64, FakeFrameDaemon::frame(1, {})));
  for (int i = 0; i < 7; ++i) daemon->came(std::vector(64, FakeFrameDaemon::frame(1, {})));
  CANSEND other(connection);
  ASSERT_TRUE(call_until(other, [&] { return (other.STAT & kReceiveOverflow) != 0; }));
  EXPECT_EQ(asked(7, 0).kind, layer2_CONTROL_RESET_OVERFLOW);
  receive.call();
  EXPECT_EQ(receive.STAT & kReceiveOverflow, 0);
  EXPECT_TRUE(receive.Rcvd) << "frames stay";
}

// 82E2 "Function code not valid", 80F1, 80F2 "Dataset assigned".
TEST_F(Canctrl, L27RetvalOfCanctrl) {
  for (const auto& [function, parameter] :
       {std::pair<INT, INT>{0, 1}, {3, 1}, {4, 1}, {8, 1}, {-1, 1}, {1, 0}, {1, 17}, {2, -1}}) {
    block.Func = function;
    block.Param = parameter;
    block.call();
    EXPECT_EQ(block.RETVAL, static_cast<INT>(0x82E2)) << function << " " << parameter;
    EXPECT_FALSE(block.error().empty());
  }
  EXPECT_TRUE(daemon->controls.empty());
  daemon->answers = false;
  block.Func = 7;
  ASSERT_TRUE(call_until(
      block, [&] { return block.RETVAL == static_cast<INT>(0x80F2) && daemon->controls.size() == 64; }));
  EXPECT_EQ(block.open(), 64);
  ASSERT_TRUE(call_until(block, [&] { return daemon->controls.size() == 64; }));
  const auto held = daemon->controls;
  for (const auto& one : held) daemon->reply(one, gateway_REPLY_REFUSED, "not now");
  CANSEND other(connection);
  ASSERT_TRUE(call_until(other, [&] { return block.open() == 0; }));
  EXPECT_EQ(block.error(), "daemon: not now");
  daemon.reset();
  ASSERT_TRUE(repeat_until([&] { block.call(); }, [&] { return block.RETVAL == static_cast<INT>(0x80F1); }));
}

}  // namespace
}  // namespace cansync::client::function_blocks
