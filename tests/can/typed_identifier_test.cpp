#include <gtest/gtest.h>

#include "can/typed/identifier.h"

namespace can {
namespace {

TEST(TypedIdentifierText, IsHexadecimalWithAndWithoutThePrefix) {
  for (const char* text : {"080", "0x080", "0X80", "0x80"}) {
    const auto identifier = typed_identifier(text);
    ASSERT_TRUE(identifier) << text;
    EXPECT_EQ(identifier->value, 0x80u) << text;
    EXPECT_FALSE(identifier->extended) << text;
  }
  for (const char* text : {"18FEF100", "0x18fef100"}) {
    const auto identifier = typed_identifier(text);
    ASSERT_TRUE(identifier) << text;
    EXPECT_EQ(identifier->value, 0x18FEF100u) << text;
    EXPECT_TRUE(identifier->extended) << text;
  }
  EXPECT_EQ(typed_identifier("128")->value, 0x128u);
}

TEST(TypedIdentifierText, WhatMayBeMeantOtherwiseIsRefused) {
  for (const char* text : {"", "0x", "80", "8", "1234", "0x1234", "800", "0x800", "2FFFFFFF", "0x123456789",
                           "12G", "-80", "+80", "0x-1", " 80"})
    EXPECT_FALSE(typed_identifier(text)) << text;
}

TEST(TypedIdentifierText, AMaskMayHaveEveryBit) {
  EXPECT_FALSE(typed_identifier("FFFFFFFF"));
  EXPECT_EQ(typed_identifier("FFFFFFFF", true)->value, 0xFFFFFFFFu);
  EXPECT_FALSE(typed_identifier("FFF", true));
}

TEST(TypedIdentifierText, DigitsAloneAreNotReadSilently) {
  EXPECT_EQ(read_as_hexadecimal("080"), "080 is read as hexadecimal: 0x080");
  for (const char* text : {"0x080", "7F0", "00000080", "0x80"})
    EXPECT_EQ(read_as_hexadecimal(text), "") << text;
}

}  // namespace
}  // namespace can
