#include "layer2/status_image.h"

#include <gtest/gtest.h>

namespace layer2 {
namespace {

TEST(StatusImage, L23StatIsStatusByte0AndStatusByte2) {
  StatusFacts facts;
  EXPECT_EQ(status_word(facts), 0x4011);  // CAN 300 PRO; both directions empty
  facts.running = true;
  EXPECT_EQ(status_word(facts), 0x4111);
  facts.transmit_errors = 96;
  EXPECT_EQ(status_word(facts), 0xC111);
}

TEST(StatusImage, L26TheQueueByteHasSendingAboveReceiving) {
  StatusFacts facts;
  facts.send.empty = false;
  EXPECT_EQ(queue_byte(facts), 0x01);
  facts.send.high_half_full = true;
  EXPECT_EQ(queue_byte(facts), 0x81);
  facts.send.overflowed = true;
  EXPECT_EQ(queue_byte(facts), 0xC1);
  facts.send.normal_half_full = true;
  EXPECT_EQ(queue_byte(facts), 0xE1);
  facts.receive = {true, true, true, false};
  EXPECT_EQ(queue_byte(facts), 0xEE);
}

TEST(StatusImage, L28TheLedBusFaultSaysTheGravestReason) {
  StatusFacts facts;
  EXPECT_EQ(name_of(bus_fault(facts)), "off");
  facts.receive.overflowed = true;
  EXPECT_EQ(name_of(bus_fault(facts)), "overflow");
  facts.receive.overflowed = false;
  facts.send.overflowed = true;
  EXPECT_EQ(name_of(bus_fault(facts)), "overflow");
  facts.receive_errors = 1;
  EXPECT_EQ(name_of(bus_fault(facts)), "errors");
  facts.transmit_errors = 127;
  EXPECT_EQ(name_of(bus_fault(facts)), "errors");
  facts.transmit_errors = 128;
  EXPECT_EQ(name_of(bus_fault(facts)), "passive");
  facts.stopped = true;
  EXPECT_EQ(name_of(bus_fault(facts)), "stopped");
  facts.bus_off = true;
  EXPECT_EQ(name_of(bus_fault(facts)), "bus-off");
}

TEST(StatusImage, L25TheErrorRegisterFollowsTheCounters) {
  StatusFacts facts;
  EXPECT_EQ(error_register(facts), 0x00);
  facts.transmit_errors = 95;
  facts.receive_errors = 95;
  EXPECT_EQ(error_register(facts), 0x00);
  facts.transmit_errors = 96;
  EXPECT_EQ(error_register(facts), 0x05);
  facts.transmit_errors = 0;
  facts.receive_errors = 96;
  EXPECT_EQ(error_register(facts), 0x03);
  facts.receive_errors = 128;
  EXPECT_EQ(error_register(facts), 0x0B);
  facts.receive_errors = 0;
  facts.transmit_errors = 128;
  EXPECT_EQ(error_register(facts), 0x15);
  facts.bus_off = true;
  EXPECT_EQ(error_register(facts), 0x35);
  facts = {};
  facts.receive_overrun = true;
  EXPECT_EQ(error_register(facts), 0x40);
}

TEST(StatusImage, L24SixteenBytes) {
  StatusFacts facts;
  facts.running = true;
  facts.transmit_errors = 300;
  facts.receive_errors = 97;
  facts.bus_off = true;
  const std::array<std::uint8_t, 16> wanted = {0xC1, 0x37, 0x11, 255, 97, 0, 0, 0, 0xFF};
  EXPECT_EQ(status_image(facts), wanted);
  facts.node = 5;
  EXPECT_EQ(status_image(facts)[8], 5);
}

}  // namespace
}  // namespace layer2
