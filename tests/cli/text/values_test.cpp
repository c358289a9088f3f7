#include "cli/text/values.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

namespace cansync::cli {
namespace {

/// The text a person sees, or "" when nothing was wrong.
template <class F>
std::string complaint(F&& parse) {
  try {
    static_cast<void>(parse());
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

std::optional<unsigned> lookup_value(std::string_view name) {
  if (name == "speed") return 5;
  if (name == "p.act") return 6;
  return std::nullopt;
}

TEST(ParseInteger, TakesDecimalHexadecimalAndSigned) {
  EXPECT_EQ(parse_integer("0", "n", 0, 10), 0);
  EXPECT_EQ(parse_integer("+10", "n", 0, 10), 10);
  EXPECT_EQ(parse_integer("0x1F", "n", 0, 255), 31);
  EXPECT_EQ(parse_integer("0Xff", "n", 0, 255), 255);
  EXPECT_EQ(parse_integer("-128", "n", -128, 0), -128);
  EXPECT_EQ(parse_integer("-0x10", "n", -128, 0), -16);
  EXPECT_EQ(parse_integer("010", "n", 0, 10), 10) << "a leading zero does not mean octal";
}

TEST(ParseInteger, RefusesWhatIsNoNumberOrOutOfRange) {
  for (const char* text : {"", "-", "+", "0x", "x1", "1x", "1 ", " 1", "1.0", "--1", "0x1G", "11", "-1",
                           "99999999999999999999", "9223372036854775808"})
    EXPECT_NE(complaint([&] { return parse_integer(text, "n", 0, 10); }), "") << text;
}

TEST(ParseInteger, SaysWhatWasFoundAndWhatIsAllowed) {
  EXPECT_EQ(complaint([] { return parse_integer("40", "SLAVE", 0, 31); }),
            "SLAVE: found '40'; allowed: 0..31, decimal or hexadecimal (0x..)");
}

TEST(ParseRaw, WordTakesUnsignedAndSigned) {
  EXPECT_EQ(parse_raw("65535", "v", Width::word), 0xFFFFu);
  EXPECT_EQ(parse_raw("-1", "v", Width::word), 0xFFFFu);
  EXPECT_EQ(parse_raw("-32768", "v", Width::word), 0x8000u);
  EXPECT_EQ(parse_raw("0x8000", "v", Width::word), 0x8000u);
  EXPECT_NE(complaint([] { return parse_raw("65536", "v", Width::word); }), "");
  EXPECT_NE(complaint([] { return parse_raw("-32769", "v", Width::word); }), "");
}

TEST(ParseRaw, DoublewordTakesUnsignedAndSigned) {
  EXPECT_EQ(parse_raw("4294967295", "v", Width::doubleword), 0xFFFFFFFFu);
  EXPECT_EQ(parse_raw("-1", "v", Width::doubleword), 0xFFFFFFFFu);
  EXPECT_EQ(parse_raw("-2147483648", "v", Width::doubleword), 0x80000000u);
  EXPECT_NE(complaint([] { return parse_raw("4294967296", "v", Width::doubleword); }), "");
  EXPECT_NE(complaint([] { return parse_raw("-2147483649", "v", Width::doubleword); }), "");
}

TEST(AsSigned, ReadsTwosComplementOfTheWidth) {
  EXPECT_EQ(as_signed(0xFFFF, Width::word), -1);
  EXPECT_EQ(as_signed(0xFFFF, Width::doubleword), 65535);
  EXPECT_EQ(as_signed(0xFFFFFFFF, Width::doubleword), -1);
  EXPECT_EQ(as_signed(0x8000, Width::word), -32768);
}

TEST(ParseReal, TakesFiniteNumbersAlone) {
  EXPECT_EQ(parse_real("12.5", "v"), 12.5);
  EXPECT_EQ(parse_real("-3e2", "v"), -300.0);
  EXPECT_EQ(parse_real("+4", "v"), 4.0);
  for (const char* text : {"", "nan", "inf", "1e999", "1.5x", "0x10", "1,5"})
    EXPECT_NE(complaint([&] { return parse_real(text, "v"); }), "") << text;
}

TEST(SlaveMask, IsHexadecimalAndNotEmpty) {
  EXPECT_EQ(parse_slave_mask("0x5"), 0x5u);
  EXPECT_EQ(parse_slave_mask("0xFFFFFFFF"), 0xFFFFFFFFu);
  for (const char* text : {"", "0x0", "0x100000000", "0x1,3"})
    EXPECT_NE(complaint([&] { return parse_slave_mask(text); }), "") << text;
}

TEST(SlaveSet, IsWrittenAsRanges) {
  EXPECT_EQ(format_slave_set(0), "-");
  EXPECT_EQ(format_slave_set(0x2F1), "0,4-7,9");
  EXPECT_EQ(format_slave_set(0xFFFFFFFF), "0-31");
  EXPECT_EQ(format_slave_set(0x80000000), "31");
}

TEST(ValueNumber, TakesNumbersPrefixedNumbersAndNames) {
  EXPECT_EQ(parse_value_number("7", lookup_value), 7u);
  EXPECT_EQ(parse_value_number("value3", lookup_value), 3u);
  EXPECT_EQ(parse_value_number("speed", lookup_value), 5u);
  for (const char* text : {"8", "-1", "value8", "value", "torque", ""})
    EXPECT_NE(complaint([&] { return parse_value_number(text, lookup_value); }), "") << text;
}

TEST(MappingWord, TakesRegisterBytesAndNames) {
  EXPECT_EQ(parse_mapping_word("0x0D", lookup_value), 0x0D);  // the manual's example
  EXPECT_EQ(parse_mapping_word("value3.low", lookup_value), 0x0D);
  EXPECT_EQ(parse_mapping_word("3.high", lookup_value), 0x0F);
  EXPECT_EQ(parse_mapping_word("speed.low", lookup_value), 0x15);
  EXPECT_EQ(parse_mapping_word("p.act.high", lookup_value), 0x1B);
  EXPECT_EQ(parse_mapping_word("-", lookup_value), 0);
  EXPECT_EQ(parse_mapping_word("0x00", lookup_value), 0);
}

TEST(MappingWord, RefusesWhatIsNoMapping) {
  // 0x0C names a value without assigning it, 0x02 only a high word, 0x21 value 8, 0x81 the reserved bit.
  for (const char* text : {"0x0C", "0x02", "0x21", "0x81", "3", "low", ".low", "8.low", "3.middle", "", "13"})
    EXPECT_NE(complaint([&] { return parse_mapping_word(text, lookup_value); }), "") << text;
}

TEST(MappingWord, WhatIsWrittenIsReadAgain) {
  for (unsigned value = 0; value < 8; ++value) {
    for (const unsigned half : {0u, 2u}) {
      const auto byte = static_cast<std::uint8_t>(1u | half | (value << 2));
      EXPECT_EQ(parse_mapping_word(format_mapping_word(byte), lookup_value), byte);
    }
  }
  EXPECT_EQ(format_mapping_word(0), "-");
  EXPECT_EQ(format_mapping_word(0x81), "0x81");
}

TEST(ParseAssignment, CutsAtTheFirstEqualsSign) {
  EXPECT_EQ(parse_assignment("speed=-5").value, "speed");
  EXPECT_EQ(parse_assignment("speed=-5").number, "-5");
  for (const char* text : {"", "=", "1=", "=1", "10"})
    EXPECT_NE(complaint([&] { return parse_assignment(text).value; }), "") << text;
}

TEST(Unscale, IsTheInverseOfTheScaling) {
  EXPECT_EQ(unscale(12.5, 0.1, 0.0, "speed"), 125);
  EXPECT_EQ(unscale(-1.0, 0.5, 1.0, "speed"), -4);
  EXPECT_EQ(unscale(0.26, 0.1, 0.0, "speed"), 3);
  EXPECT_EQ(unscale(-2147483648.0, 1.0, 0.0, "speed"), std::numeric_limits<std::int32_t>::min());
}

TEST(Unscale, RefusesWhatDoesNotFit) {
  EXPECT_EQ(complaint([] { return unscale(1e12, 0.5, 0.0, "speed"); }),
            "speed: found '1000000000000'; allowed: -1.07374e+09..1.07374e+09");
  EXPECT_NE(complaint([] { return unscale(-2147483649.0, 1.0, 0.0, "speed"); }), "");
  EXPECT_NE(complaint([] { return unscale(1.0, 0.0, 0.0, "speed"); }), "");
}

}  // namespace
}  // namespace cansync::cli
