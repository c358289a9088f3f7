// FC 70 CANSEND_SAE_J1939 and FC 71 CANRCV_SAE_J1939, sections 7.9.2 and 7.9.3 of the manual of the CAN 300
// PRO (edition 3), with STAT of 7.2.5 and RETVAL of 8.
#include <cansync/function_blocks/module_codes.h>

#include "message_rig.h"

namespace cansync::client::function_blocks {
namespace {

constexpr WORD kReady = 0x4100;            // "CAN 300 PRO", runs
constexpr WORD kSendEmpty = 0x0010;        // bit 4
constexpr WORD kSendOverflow = 0x0040;     // bit 6
constexpr WORD kSendHalf = 0x0020;         // bit 5
constexpr WORD kReceiveEmpty = 0x0001;     // bit 0
constexpr WORD kReceiveOverflow = 0x0004;  // bit 2
constexpr WORD kReceiveHalf = 0x0002;      // bit 1
constexpr WORD kGroupError = 0x8000;       // bit 15

class CansendSaeJ1939 : public MessageBlockTest {
 protected:
  CANSEND_SAE_J1939 block{connection};
  void SetUp() override {
    block.Source_Addr = 0x21;
    block.PDU_Format = 0xFE;
    block.PDU_Specific = 0xF1;
  }
  /// Sends, and waits until the daemon has so many requests.
  void send_until(std::size_t count) {
    block.Snd = true;
    ASSERT_TRUE(call_until(block, [&] { return daemon->asked.size() >= count; })) << block.error();
  }
};

// "transfers a CAN frame to the module": Priority, DataPageBit, PDU_Format, PDU_Specific, Source_Addr,
// B0..B7.
TEST_F(CansendSaeJ1939, J5EveryInputStandsInTheFrame) {
  block.Priority = 3;
  block.DataPageBit = true;
  block.B0 = 1;
  block.B3 = 0x7F;
  block.B7 = 0xFE;
  send_until(1);
  const auto& asked = daemon->asked[0];
  EXPECT_EQ(asked.sample.kind, j1939_MESSAGE_SEND);
  EXPECT_EQ(asked.sample.pgn, 0x1FEF1u);
  EXPECT_EQ(asked.sample.priority, 3);
  EXPECT_EQ(asked.sample.destination, 255);
  EXPECT_EQ(asked.data, (std::vector<std::uint8_t>{1, 0, 0, 0x7F, 0, 0, 0, 0xFE})) << "always 8 bytes";
  EXPECT_EQ(block.RETVAL, module_code::done);
}

// "0...239: PDU1 Format: DA (Destination Address)".
TEST_F(CansendSaeJ1939, J5BelowFormat240PduSpecificIsTheDestination) {
  block.PDU_Format = 239;
  block.PDU_Specific = 0x33;
  send_until(1);
  EXPECT_EQ(daemon->asked[0].sample.pgn, 0xEF00u);
  EXPECT_EQ(daemon->asked[0].sample.destination, 0x33);
}

// "The bit Snd is always reset after the block has been executed. The frame to be transmitted is always
// transferred to the module."
TEST_F(CansendSaeJ1939, J6SndIsAlwaysResetAndTheFrameAlwaysTaken) {
  daemon->answers = false;
  for (unsigned i = 0; i < 100; ++i) {
    block.B0 = static_cast<BYTE>(i);
    block.Snd = true;
    block.call();
    EXPECT_FALSE(block.Snd);
    EXPECT_EQ(block.RETVAL, module_code::done);
  }
  daemon->answers = true;
  ASSERT_TRUE(call_until(block, [&] {
    for (const auto& one : daemon->asked) daemon->reply(one.sample, gateway_REPLY_DONE);
    return daemon->asked.size() == 100;
  }));
  for (unsigned i = 0; i < 100; ++i) EXPECT_EQ(daemon->asked[i].data[0], i) << "in their order, each once";
}

// "If the transmit buffer in the module is full, older frames that have not been transmitted yet are deleted.
// To prevent that, bit 4 of the STAT byte must always be queried before transmission."
TEST_F(CansendSaeJ1939, J7AFullBufferDeletesTheOldestAndBit4SaysWhenItIsEmpty) {
  daemon->answers = false;
  EXPECT_TRUE(call_until(block, [&] { return (block.STAT & kSendEmpty) != 0; }));
  const auto enter = [&](unsigned number) {
    block.B0 = static_cast<BYTE>(number & 0xFF);
    block.B1 = static_cast<BYTE>(number >> 8);
    block.Snd = true;
    block.call();
  };
  for (unsigned i = 0; i < 40; ++i) enter(i);
  ASSERT_TRUE(call_until(block, [&] { return daemon->asked.size() == 40; }))
      << "what the daemon takes at a time";
  EXPECT_EQ(block.STAT & kSendEmpty, 0);
  for (unsigned i = 40; i < 239; ++i) enter(i);
  EXPECT_EQ(block.STAT & kSendHalf, 0);
  enter(239);
  EXPECT_NE(block.STAT & kSendHalf, 0) << "200 of 400";
  for (unsigned i = 240; i < 440; ++i) enter(i);
  EXPECT_EQ(block.STAT & kSendOverflow, 0);
  enter(440);
  EXPECT_NE(block.STAT & kSendOverflow, 0) << "number 40 is gone";
  const auto held = daemon->asked;
  for (const auto& one : held) daemon->reply(one.sample, gateway_REPLY_DONE);
  daemon->answers = true;
  ASSERT_TRUE(call_until(block, [&] { return (block.STAT & kSendEmpty) != 0; }));
  ASSERT_EQ(daemon->asked.size(), 440u);
  EXPECT_EQ(daemon->asked[40].data[0], 41);
  EXPECT_EQ(daemon->asked[439].data[0] | daemon->asked[439].data[1] << 8, 440);
  EXPECT_NE(block.STAT & kSendOverflow, 0) << "the bit stays";
}

// "The parameter is always assigned value, even if the Snd bit is not set."
TEST_F(CansendSaeJ1939, J9StatIsThereWithEveryCall) {
  block.call();
  EXPECT_EQ(block.STAT & kReady, kReady);
  daemon->bus.transmit_errors = 96;
  daemon->tell_bus();
  EXPECT_TRUE(call_until(block, [&] { return (block.STAT & kGroupError) != 0; }));
  daemon->bus.transmit_errors = 0;
  daemon->tell_bus();
  EXPECT_TRUE(call_until(block, [&] { return block.STAT == (kReady | kSendEmpty | kReceiveEmpty); }));
  daemon->claim("cannot-claim");
  EXPECT_TRUE(call_until(block, [&] { return (block.STAT & 0x0100) == 0; })) << "it does not run";
}

// 80F1 "Module not ready"; 81E1 "Node number not valid"; 82E2 for every other input.
TEST_F(CansendSaeJ1939, J10RetvalSaysWhyNothingIsSent) {
  const auto retval = [&] {
    block.Snd = true;
    block.call();
    EXPECT_FALSE(block.Snd);
    return block.RETVAL;
  };
  const auto wrong = [&](INT& input, INT value, INT code, const char* word) {
    const INT before = input;
    input = value;
    EXPECT_EQ(retval(), code);
    EXPECT_NE(block.error().find(word), std::string::npos) << block.error();
    input = before;
  };
  for (const INT value : {INT{-1}, INT{8}}) wrong(block.Priority, value, module_code::input_invalid, "0..7");
  for (const INT value : {INT{-1}, INT{256}}) {
    wrong(block.PDU_Format, value, module_code::input_invalid, "PDU_Format");
    wrong(block.PDU_Specific, value, module_code::input_invalid, "PDU_Specific");
    wrong(block.Source_Addr, value, module_code::node_invalid, "33");
  }
  wrong(block.Source_Addr, 0x22, module_code::node_invalid, "address.preferred");
  block.PDU_Format = 100;
  wrong(block.PDU_Specific, 254, module_code::input_invalid, "destination");
  daemon->claim("claiming");
  ASSERT_TRUE(call_until(block, [&] { return (block.STAT & 0x0100) == 0; }));
  EXPECT_EQ(retval(), static_cast<INT>(0x80F1));
  EXPECT_NE(block.error().find("claiming"), std::string::npos) << block.error();
  daemon->claim("claimed");
  ASSERT_TRUE(call_until(block, [&] { return (block.STAT & 0x0100) != 0; }));
  EXPECT_EQ(retval(), module_code::done);
  EXPECT_TRUE(call_until(block, [&] { return daemon->asked.size() == 1; }))
      << "of all these only the last was sent";
}

TEST_F(CansendSaeJ1939, J10AFrameThatFailsIsTold) {
  daemon->answers = false;
  send_until(1);
  daemon->reply(daemon->asked[0].sample, gateway_REPLY_TIMEOUT, "the interface is down");
  ASSERT_TRUE(call_until(block, [&] { return block.failures() == 1; }));
  EXPECT_EQ(block.error(), "daemon: the interface is down");
  EXPECT_EQ(block.RETVAL, module_code::done) << "RETVAL is that of the call";
}

// What was entered for the daemon before must not be sent by the next one.
TEST_F(CansendSaeJ1939, J10AfterARestartTheFirstFrameIsRefused) {
  daemon->answers = false;
  block.Snd = true;
  for (int i = 0; i < 60; ++i) {
    block.Snd = true;
    block.call();
  }
  daemon.reset();
  daemon.emplace(places.here);
  ASSERT_TRUE(
      call_until(block, [&] { return (block.STAT & kSendEmpty) != 0 && (block.STAT & 0x0100) != 0; }));
  EXPECT_TRUE(daemon->asked.empty());
  block.Snd = true;
  block.call();
  EXPECT_EQ(block.RETVAL, module_code::not_ready);
  EXPECT_NE(block.error().find("started anew"), std::string::npos) << block.error();
  send_until(1);
}

// A request that nobody is known to read reaches nobody.
TEST_F(CansendSaeJ1939, J10AMessageWaitsUntilTheNewDaemonIsKnownToReadMessages) {
  restart_unread(block);
  daemon->read_requests();
  EXPECT_TRUE(call_until(block, [&] { return daemon->asked.size() == 1; })) << block.error();
  EXPECT_EQ(block.failures(), 0u);
}

class CanrcvSaeJ1939 : public MessageBlockTest {
 protected:
  CANRCV_SAE_J1939 block{connection};
};

// "If the function block has read a frame from the CAN 300 PRO module, bit Recd is set."
TEST_F(CanrcvSaeJ1939, J8GivesOneFrameACallWithEveryOutput) {
  daemon->message(0x1FEF1, 255, {1, 2, 3, 4, 5, 6, 7, 8});
  daemon->message(0xEF00, 0x21, {9, 10});
  ASSERT_TRUE(call_until(block, [&] { return BOOL{block.Recd}; }));
  EXPECT_EQ(block.Priority, 3);
  EXPECT_TRUE(block.DataPageBit);
  EXPECT_EQ(block.PDU_Format, 0xFE);
  EXPECT_EQ(block.PDU_Specific, 0xF1);
  EXPECT_EQ(block.Source_Addr, 0x44);
  EXPECT_EQ((std::array{block.B0, block.B1, block.B2, block.B3, block.B4, block.B5, block.B6, block.B7}),
            (std::array<BYTE, 8>{1, 2, 3, 4, 5, 6, 7, 8}));
  EXPECT_EQ(block.length(), 8);
  ASSERT_TRUE(call_until(block, [&] { return BOOL{block.Recd}; }));
  EXPECT_FALSE(block.DataPageBit);
  EXPECT_EQ(block.PDU_Format, 0xEF);
  EXPECT_EQ(block.PDU_Specific, 0x21) << "the destination";
  EXPECT_EQ(block.length(), 2);
  EXPECT_EQ((std::array{block.B0, block.B1, block.B2, block.B7}), (std::array<BYTE, 4>{9, 10, 0xFF, 0xFF}));
  block.call();
  EXPECT_FALSE(block.Recd);
  EXPECT_EQ(block.B0, 9) << "changes with a frame only";
}

// "Multipacket messages are currently not supported."
TEST_F(CanrcvSaeJ1939, J8MessagesInPacketsDoNotComeHere) {
  daemon->message(0xFECA, 255, std::vector<std::uint8_t>(20, 1), j1939_TRANSPORT_BROADCAST);
  daemon->message(0xFEF1, 255, {7});
  ASSERT_TRUE(call_until(block, [&] { return BOOL{block.Recd}; }));
  EXPECT_EQ(block.B0, 7);
}

// "The parameter is always assigned a value even if no frame has been received."
TEST_F(CanrcvSaeJ1939, J9StatSaysHowFullTheBufferIs) {
  block.call();
  EXPECT_EQ(block.STAT & (kReady | kReceiveEmpty), kReady | kReceiveEmpty);
  CANSEND_SAE_J1939 other(connection);  // takes what comes, and reads nothing
  daemon->burst(0, 200);
  ASSERT_TRUE(call_until(other, [&] { return (other.STAT & kReceiveHalf) != 0; }));
  EXPECT_EQ(other.STAT & kReceiveEmpty, 0);
  daemon->burst(200, 201);
  ASSERT_TRUE(call_until(other, [&] { return (other.STAT & kReceiveOverflow) != 0; }));
  block.call();
  EXPECT_EQ(block.B0, 1) << "the oldest is deleted";
}

TEST_F(CanrcvSaeJ1939, J9FramesLostOnTheWayAreAnOverflow) {
  daemon->message(0xFEF1, 255, {1});
  daemon->message(0xFEF1, 255, {2}, j1939_TRANSPORT_FRAME, 3);
  ASSERT_TRUE(call_until(block, [&] { return block.B0 == 2; }));
  EXPECT_NE(block.STAT & kReceiveOverflow, 0);
}

TEST_F(CanrcvSaeJ1939, J10RetvalSaysThatTheDaemonIsGone) {
  block.call();
  EXPECT_EQ(block.RETVAL, module_code::done);
  daemon->claim("listening");
  daemon->message(0xFEF1, 255, {1});
  ASSERT_TRUE(call_until(block, [&] { return BOOL{block.Recd}; })) << "listening is enough";
  EXPECT_EQ(block.RETVAL, module_code::done);
  daemon.reset();
  ASSERT_TRUE(repeat_until([&] { block.call(); }, [&] { return block.RETVAL == module_code::not_ready; }));
  EXPECT_EQ(block.error(), "client: no daemon serves the bus");
  EXPECT_EQ(block.STAT & 0x0100, 0);
}

TEST(MessageConnectionTest, FindsNoDaemonAndSaysSo) {
  TwoPlaces places;
  Options options = options_at(places.there);
  options.wait = std::chrono::milliseconds(20);
  EXPECT_THROW((void)MessageConnection::connect(options), NoDaemon);
}

}  // namespace
}  // namespace cansync::client::function_blocks
