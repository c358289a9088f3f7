#include <gtest/gtest.h>

#include <array>
#include <string>
#include <string_view>

#include "dbc/reader.h"

namespace dbc {
namespace {

constexpr std::string_view kFile = R"(VERSION ""

NS_ :
	NS_DESC_
	CM_
	VAL_
	BO_TX_BU_

BS_:

BU_: ECU1 ECU2
     ECU3

VAL_TABLE_ onoff 1 "on" 0 "off" ;

BO_ 291 Motor: 8 ECU1
 SG_ Speed : 0|16@1+ (0.125,-10) [0|8031.875] "rpm" ECU2,ECU3
 SG_ Torque : 16|8@1- (1,0) [-128|127] "%" ECU2
 SG_ Big : 31|12@0+ (1,0) [0|4095] "" Vector__XXX
 SG_ Mode M : 48|4@1+ (1,0) [0|15] "" ECU2
 SG_ Warm m1 : 56|8@1+ (0.5,-40) [0|0] "°C" ECU2
 SG_ Cold m2 : 56|8@1- (1,0) [0|0] "" ECU2

BO_ 2566842110 Engine: 8 ECU1
 SG_ Ratio : 0|32@1- (1,0) [0|0] "" ECU2
 SG_ Hour : 32|32@1+ (5E-002,0) [0|0] "h" ECU2

BO_ 3221225472 VECTOR__INDEPENDENT_SIG_MSG: 0 Vector__XXX
 SG_ Nowhere : 0|8@1+ (1,0) [0|0] "" Vector__XXX

CM_ SG_ 291 Speed "a comment
BO_ 1 which is none: 8 X; with \"quotation\" ;";
BA_DEF_ BO_ "GenMsgCycleTime" INT 0 0;
VAL_ 291 Torque 0 "none" -1 "back" ;
VAL_ EnvironmentVariable 0 "x" ;
VAL_ 3221225472 Nowhere 0 "x" ;
SIG_VALTYPE_ 2566842110 Ratio : 1;
)";

Database good(std::string_view text) {
  File file = read_database(text);
  EXPECT_EQ(file.refused, "");
  for (const Remark& remark : file.remarks)
    ADD_FAILURE() << remark.line << ":" << remark.column << ": " << remark.text;
  return std::move(file.database);
}

/// A message with this one signal.
std::string with_signal(std::string_view signal, unsigned length = 8) {
  return "BO_ 1 A: " + std::to_string(length) + " X\n SG_ " + std::string(signal) + "\n";
}

TEST(DbcReader, MessagesHaveTheirIdentifierAndWidth) {
  const Database file = good(kFile);
  ASSERT_EQ(file.messages().size(), 2u);
  ASSERT_NE(file.find(0x123, false), nullptr);
  EXPECT_EQ(file.find(0x123, false)->name, "Motor");
  EXPECT_EQ(file.find(0x123, true), nullptr);
  ASSERT_NE(file.find(0x18FEE6FE, true), nullptr);
  EXPECT_EQ(file.find(0x18FEE6FE, true)->name, "Engine");
  EXPECT_EQ(file.find(0x124, false), nullptr);
}

TEST(DbcReader, SignalsAreTakenOutOfTheirBits) {
  const Database file = good(kFile);
  // Speed 0x1234 = 4660; Torque -1; Big 0xABC from bit 31 down; Mode 1, so Warm is there: 0x60 = 96.
  const std::array<std::uint8_t, 8> data = {0x34, 0x12, 0xFF, 0xAB, 0xC5, 0x00, 0xF1, 0x60};
  const auto found = read_signals(*file.find(0x123, false), data);
  ASSERT_EQ(found.size(), 5u);
  EXPECT_EQ(found[0].signal->name, "Speed");
  EXPECT_EQ(found[0].raw, 0x1234u);
  EXPECT_DOUBLE_EQ(found[0].value, 4660 * 0.125 - 10);
  EXPECT_EQ(found[0].signal->unit, "rpm");
  EXPECT_DOUBLE_EQ(found[1].value, -1.0);
  EXPECT_EQ(found[1].word, "back");
  EXPECT_EQ(found[2].raw, 0xABCu);
  EXPECT_EQ(found[3].raw, 1u);
  EXPECT_EQ(found[4].signal->name, "Warm");
  EXPECT_DOUBLE_EQ(found[4].value, 8.0);
  EXPECT_EQ(found[4].signal->unit, "°C");
}

TEST(DbcReader, WhatIsNotThereIsNotShown) {
  const Database file = good(kFile);
  const std::array<std::uint8_t, 3> part = {0, 0, 0};
  EXPECT_EQ(read_signals(*file.find(0x123, false), part).size(), 2u);
  const std::array<std::uint8_t, 8> third = {0, 0, 0, 0, 0, 0, 3, 0};  // nothing is chosen by 3
  EXPECT_EQ(read_signals(*file.find(0x123, false), third).size(), 4u);
  EXPECT_TRUE(read_signals(*file.find(0x123, false), {}).empty());
}

TEST(DbcReader, NumbersMayHaveAPoint) {
  const Database file = good(kFile);
  const std::array<std::uint8_t, 8> data = {0x00, 0x00, 0x20, 0xC0, 0x14, 0, 0, 0};  // -2.5; 20
  const auto found = read_signals(*file.find(0x18FEE6FE, true), data);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_DOUBLE_EQ(found[0].value, -2.5);
  EXPECT_DOUBLE_EQ(found[1].value, 1.0);
}

TEST(DbcReader, MessagesOfPacketsMayBeLong) {
  const Database file = good(with_signal("End : 14272|8@1+ (1,0) [0|0] \"\" X", 1785));
  std::vector<std::uint8_t> data(1785);
  data.back() = 7;
  EXPECT_EQ(read_signals(file.messages()[0], data).at(0).raw, 7u);
}

TEST(DbcReader, OldCharactersBecomeUtf8) {
  const Database file =
      good(with_signal("T : 0|8@1+ (1,0) [0|0] \"\xB0"
                       "C\" X"));
  EXPECT_EQ(file.messages()[0].signals[0].unit, "°C");
}

TEST(DbcReader, RemarksHaveLineAndColumn) {
  const auto remarks =
      read_database("VERSION \"\"\nBO_ 1 A: 8 X\n SG_ S : 0|65@1+ (1,0) [0|0] \"\" X\nBO_ 2 B 8 X\n").remarks;
  ASSERT_EQ(remarks.size(), 2u);
  EXPECT_EQ(remarks[0].line, 3u);
  EXPECT_EQ(remarks[0].column, 12u);
  EXPECT_EQ(remarks[0].text,
            "found '65'; allowed: of over 64 bits a text, which has whole bytes; the signal is left out");
  EXPECT_EQ(remarks[1].line, 4u);
  EXPECT_EQ(remarks[1].column, 9u);
  EXPECT_EQ(remarks[1].text, "found '8'; allowed: ':'; the message and its signals are left out");
}

TEST(DbcReader, RemarksAreKeptUpToALimitAndCountedBehindIt) {
  std::string text;
  for (std::size_t i = 0; i < kMostRemarks + 100; ++i) text += "BO_ x\n";
  const File file = read_database(text);
  EXPECT_EQ(file.remarks.size(), kMostRemarks);
  EXPECT_EQ(file.more_remarks, 100u);
}

TEST(DbcReader, SignalsOfAMessageAreBounded) {
  std::string text = "BO_ 1 A: 8 X\n";
  for (std::size_t i = 0; i < kMostSignals + 2; ++i)
    text += " SG_ S" + std::to_string(i) + " : 0|8@1+ (1,0) [0|0] \"\" X\n";
  const File file = read_database(text);
  EXPECT_EQ(file.database.messages().at(0).signals.size(), kMostSignals);
  EXPECT_EQ(file.remarks.size(), 2u);
}

}  // namespace
}  // namespace dbc
