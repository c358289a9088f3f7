#include "can/frame_length.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <initializer_list>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "can/frame.h"

namespace {

using can::Frame;
using Bits = std::vector<int>;

// --- The reference: one bit after the other, as the standard's text puts it.

void append(Bits& bits, std::uint64_t value, unsigned count) {
  while (count-- > 0) bits.push_back(static_cast<int>((value >> count) & 1));
}

Bits message(const Frame& frame) {
  const bool remote = frame.remote;
  Bits bits;
  append(bits, 0, 1);
  if (frame.extended) {
    append(bits, frame.id >> 18, 11);
    append(bits, 3, 2);
    append(bits, frame.id & 0x3FFFF, 18);
    append(bits, remote ? 1 : 0, 1);
    append(bits, 0, 2);
  } else {
    append(bits, frame.id, 11);
    append(bits, remote ? 1 : 0, 1);
    append(bits, 0, 2);
  }
  append(bits, frame.dlc, 4);
  for (unsigned i = 0; i < frame.dlc && !remote; ++i) append(bits, frame.data[i], 8);
  return bits;
}

unsigned slow_crc(const Bits& bits) {
  unsigned crc = 0;
  for (const int bit : bits) {
    const unsigned next = static_cast<unsigned>(bit) ^ ((crc >> 14) & 1);
    crc = (crc << 1) & 0x7FFF;
    if (next != 0) crc ^= 0x4599;
  }
  return crc;
}

unsigned slow_stuff_bits(const Bits& bits) {
  unsigned stuffed = 0;
  int level = -1;
  int in_row = 0;
  for (const int bit : bits) {
    in_row = bit == level ? in_row + 1 : 1;
    level = bit;
    if (in_row == 5) {
      ++stuffed;
      level = 1 - level;
      in_row = 1;
    }
  }
  return stuffed;
}

void expect_as_reference(const Frame& frame) {
  Bits bits = message(frame);
  const unsigned crc = slow_crc(bits);
  append(bits, crc, 15);
  const std::string what = "id " + std::to_string(frame.id) + " dlc " + std::to_string(frame.dlc) +
                           (frame.extended ? " extended" : "") + (frame.remote ? " remote" : "");
  ASSERT_EQ(can::crc15(frame), crc) << what;
  ASSERT_EQ(can::stuff_bits(frame), slow_stuff_bits(bits)) << what;
  ASSERT_EQ(can::frame_bits(frame), bits.size() + slow_stuff_bits(bits) + 1 + 2 + 7 + 3) << what;
}

// Few bits set, so that rows of equal bits are far longer than in a plain random number.
std::uint64_t sparse(std::mt19937_64& random, unsigned numbers) {
  std::uint64_t bits = ~std::uint64_t{0};
  while (numbers-- > 0) bits &= random();
  return bits;
}

Frame data_frame(std::uint32_t id, std::initializer_list<int> bytes) {
  Frame frame;
  frame.id = id;
  for (const int byte : bytes) frame.data[frame.dlc++] = static_cast<std::uint8_t>(byte);
  return frame;
}

TEST(FrameLength, ReferenceCrcHasThePublishedCheckValue) {
  Bits bits;
  for (const char c : std::string_view("123456789")) append(bits, static_cast<std::uint8_t>(c), 8);
  EXPECT_EQ(slow_crc(bits), 0x059Eu);  // CRC-15/CAN
}

TEST(FrameLength, CrcOfFramesWorkedOutByHand) {
  // Nothing but dominant bits leaves the register at 0.
  EXPECT_EQ(can::crc15(data_frame(0, {})), 0);
  // A remote frame with identifier 0 and length 0 has one recessive bit, RTR, six places before the end:
  // x^(15+6) mod x^15+x^14+x^10+x^8+x^7+x^4+x^3+1. x^15 = 4599, x^16 = 4EAB, x^17 = 58CF, x^18 = 7407,
  // x^19 = 2D97, x^20 = 5B2E, x^21 = 73C5.
  Frame remote;
  remote.remote = true;
  EXPECT_EQ(can::crc15(remote), 0x73C5);
  // Length code 1 is the message's last bit but for the data byte: x^(15+8) + x^15.
  // x^22 = 2213, x^23 = 4426; 4426 ^ 4599 = 01BF.
  EXPECT_EQ(can::crc15(data_frame(0, {0x01})), 0x01BF);
}

TEST(FrameLength, LengthsOfTheSpecification) {
  EXPECT_EQ(can::unstuffed_bits(8), 111u);
  EXPECT_EQ(can::worst_case_bits(8), 135u);
  EXPECT_EQ(can::unstuffed_bits(0), 47u);
  EXPECT_EQ(can::worst_case_bits(0), 55u);
  EXPECT_EQ(can::unstuffed_bits(4), 79u);
  EXPECT_EQ(can::worst_case_bits(4), 95u);
  EXPECT_EQ(can::unstuffed_bits(15), 111u) << "a length over 8 counts as 8";
}

TEST(FrameLength, FewStuffBits) {
  // Alternating levels: only the dominant bits RTR, IDE, r0 and the length code's are in a row.
  const Frame frame = data_frame(0x555, {0x55, 0x55, 0x55, 0x55, 0x55, 0x55, 0x55, 0x55});
  EXPECT_EQ(can::crc15(frame), 0x1B04);
  EXPECT_EQ(can::stuff_bits(frame), 1u);
  EXPECT_EQ(can::frame_bits(frame), 112u);
}

TEST(FrameLength, WorstFrameThatExists) {
  // RTR, IDE, r0 and the length code are fixed, so 24 stuff bits cannot be had. A search over all headers and
  // data that could give 23 finds none whose CRC plays along; 22 is the most.
  const Frame frame = data_frame(0x000, {0x01, 0xE1, 0xE1, 0xE1, 0xE1, 0xE1, 0xE1, 0xE1});
  EXPECT_EQ(can::stuff_bits(frame), 22u);
  EXPECT_EQ(can::frame_bits(frame), 133u);
  EXPECT_EQ(can::stuff_bits(data_frame(0x03E, {0x01, 0xE0, 0x0F, 0x83, 0xC3, 0xFE, 0x1E, 0x1E})), 22u);
}

TEST(FrameLength, StuffBitCountsForTheNextRow) {
  // 00000 1 1111 0 ...: the stuff bit begins the row of five that is stuffed next.
  const Frame frame = data_frame(0x078, {});
  expect_as_reference(frame);
  EXPECT_GE(can::stuff_bits(frame), 2u);
}

TEST(FrameLength, AsBitByBitForEveryStandardIdentifierAndLength) {
  std::mt19937_64 random(1);
  for (std::uint32_t id = 0; id <= 0x7FF; ++id) {
    Frame frame;
    frame.id = id;
    for (frame.dlc = 0; frame.dlc <= 8; ++frame.dlc) {
      for (unsigned i = 0; i < frame.dlc; ++i) frame.data[i] = static_cast<std::uint8_t>(random());
      expect_as_reference(frame);
      if (HasFatalFailure()) return;
    }
  }
}

TEST(FrameLength, AsBitByBitForFramesWithLongRows) {
  std::mt19937_64 random(2);
  for (int n = 0; n < 50'000; ++n) {
    Frame frame;
    const auto kind = random() % 4;
    frame.extended = kind % 2 == 1;
    frame.remote = kind >= 2;
    frame.id = static_cast<std::uint32_t>(sparse(random, 2)) & (frame.extended ? 0x1FFFFFFFu : 0x7FFu);
    frame.dlc = static_cast<std::uint8_t>(random() % 9);
    const std::uint64_t few = sparse(random, 3);
    const std::uint64_t data = n % 2 == 0 ? few : ~few;
    for (unsigned i = 0; i < frame.dlc; ++i) frame.data[i] = static_cast<std::uint8_t>(data >> (8 * i));
    expect_as_reference(frame);
    if (HasFatalFailure()) return;
    if (frame.is_standard_data()) {
      ASSERT_GE(can::frame_bits(frame), can::unstuffed_bits(frame.dlc));
      ASSERT_LE(can::frame_bits(frame), can::worst_case_bits(frame.dlc));
    }
  }
}

TEST(FrameLength, RemoteFrameHasItsLengthCodeButNoData) {
  Frame frame = data_frame(0x123, {1, 2, 3, 4});
  frame.remote = true;
  EXPECT_EQ(can::frame_bits(frame) - can::stuff_bits(frame), can::unstuffed_bits(0));
}

TEST(FrameLength, ExtendedFrameIsTwentyBitsLonger) {
  Frame frame = data_frame(0x12345678, {1, 2, 3, 4, 5, 6, 7, 8});
  frame.extended = true;
  EXPECT_EQ(can::frame_bits(frame) - can::stuff_bits(frame), 131u);
}

TEST(FrameLength, ErrorFrame) {
  Frame frame;
  frame.error = true;
  EXPECT_EQ(can::frame_bits(frame), 18u);
  EXPECT_EQ(can::stuff_bits(frame), 0u);
  EXPECT_EQ(can::crc15(frame), 0);
}

TEST(FrameLength, LengthOverEightCountsAsEight) {
  Frame frame = data_frame(0x123, {1, 2, 3, 4, 5, 6, 7, 8});
  const unsigned bits = can::frame_bits(frame);
  frame.dlc = 12;
  EXPECT_EQ(can::frame_bits(frame), bits);
}

}  // namespace
