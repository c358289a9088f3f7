// From values to the bytes of a message.
#include <gtest/gtest.h>

#include <array>
#include <limits>

#include "dbc/encode.h"

namespace dbc {
namespace {

Signal signal(unsigned start, unsigned length, bool little_endian, NumberKind kind, double factor = 1,
              double offset = 0) {
  Signal out;
  out.name = "value";
  out.start = start;
  out.length = length;
  out.little_endian = little_endian;
  out.kind = kind;
  out.factor = factor;
  out.offset = offset;
  return out;
}

// Engine speed in EEC1 of J1939: SPN 190, bytes 4 and 5, 0.125 rpm a bit; coolant in ET1: SPN 110, byte 1,
// -40.
TEST(Encode, ValuesOfJ1939) {
  std::array<std::uint8_t, 8> data;
  data.fill(0xFF);
  const Signal speed = signal(24, 16, true, NumberKind::unsigned_integer, 0.125);
  EXPECT_TRUE(write_bits(speed, *raw_of(speed, 1200), data));
  EXPECT_EQ(data, (std::array<std::uint8_t, 8>{0xFF, 0xFF, 0xFF, 0x80, 0x25, 0xFF, 0xFF, 0xFF}));
  const Signal coolant = signal(0, 8, true, NumberKind::unsigned_integer, 1, -40);
  EXPECT_EQ(raw_of(coolant, 85), 125u);
  EXPECT_EQ(range_of(coolant), (std::pair{-40.0, 215.0}));
}

TEST(Encode, OutOfRangeIsNothing) {
  const Signal byte = signal(0, 8, true, NumberKind::signed_integer, 0.5, 10);
  EXPECT_EQ(range_of(byte), (std::pair{-54.0, 73.5}));
  EXPECT_EQ(raw_of(byte, -54), 0x80u);
  EXPECT_EQ(raw_of(byte, 73.5), 0x7Fu);
  EXPECT_EQ(raw_of(byte, 9.5), 0xFFu);
  EXPECT_EQ(raw_of(byte, 73.76), std::nullopt);
  EXPECT_EQ(raw_of(byte, -54.26), std::nullopt);
  EXPECT_EQ(raw_of(byte, std::numeric_limits<double>::quiet_NaN()), std::nullopt);
  EXPECT_EQ(raw_of(byte, std::numeric_limits<double>::infinity()), std::nullopt);
  const Signal falling = signal(0, 8, true, NumberKind::unsigned_integer, -1);
  EXPECT_EQ(range_of(falling), (std::pair{-255.0, 0.0}));
  const Signal widest = signal(0, 64, true, NumberKind::unsigned_integer);
  EXPECT_EQ(raw_of(widest, 18446744073709551615.0), std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(raw_of(widest, -1), std::nullopt);
}

// From 55 bits on the highest number of a signed signal is no double: its neighbour stands for it.
TEST(Encode, TheHighestNumberOfALongSignedSignalIsNotTheLowest) {
  for (unsigned length = 2; length <= 64; ++length) {
    const Signal whole = signal(0, length, true, NumberKind::signed_integer);
    const std::uint64_t sign = std::uint64_t{1} << (length - 1);
    EXPECT_EQ(raw_of(whole, range_of(whole).second), sign - 1) << length;
    EXPECT_EQ(raw_of(whole, range_of(whole).first), sign) << length;
  }
}

TEST(Encode, NamesOfValues) {
  Signal gear = signal(0, 4, true, NumberKind::unsigned_integer);
  gear.words = {{0, "park"}, {15, "not available"}};
  EXPECT_EQ(raw_of(gear, "not available"), 15u);
  EXPECT_EQ(raw_of(gear, "drive"), std::nullopt);
}

// What was written is read again, wherever it lies, and nothing else changes.
TEST(Encode, WhatIsWrittenIsRead) {
  for (const bool little_endian : {true, false}) {
    for (unsigned length = 1; length <= 64; ++length) {
      for (unsigned start = 0; start < 64; ++start) {
        const Signal one = signal(start, length, little_endian, NumberKind::unsigned_integer);
        std::array<std::uint8_t, 8> zeros = {};
        std::array<std::uint8_t, 8> all;
        all.fill(0xFF);
        const std::uint64_t raw = 0xA5C3'96F1'0F5A'3C69u >> (64 - length);
        if (!write_bits(one, raw, zeros)) {
          EXPECT_FALSE(raw_bits(one, zeros)) << "it does not lie in eight bytes";
          EXPECT_EQ(zeros, (std::array<std::uint8_t, 8>{}));
          continue;
        }
        EXPECT_TRUE(write_bits(one, raw, all));
        EXPECT_EQ(raw_bits(one, zeros), raw);
        EXPECT_EQ(raw_bits(one, all), raw);
        for (std::size_t i = 0; i < 8; ++i) {
          const unsigned others = zeros[i] ^ all[i];
          EXPECT_EQ(others & (zeros[i] & 0xFFu), 0u);
        }
      }
    }
  }
}

TEST(Encode, FloatingPoint) {
  std::array<std::uint8_t, 8> data = {};
  const Signal small = signal(0, 32, true, NumberKind::float32);
  EXPECT_TRUE(write_bits(small, *raw_of(small, 1.5), data));
  EXPECT_EQ(data, (std::array<std::uint8_t, 8>{0, 0, 0xC0, 0x3F, 0, 0, 0, 0}));
  EXPECT_EQ(raw_of(small, 1e300), std::nullopt);
  const Signal large = signal(0, 64, true, NumberKind::float64);
  EXPECT_EQ(raw_of(large, -2.0), 0xC000'0000'0000'0000u);
}

}  // namespace
}  // namespace dbc
