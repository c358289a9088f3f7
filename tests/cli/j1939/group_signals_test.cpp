// Signals of J1939 by name: groups whatever their priority and source, what is not available, sending.
#include "cli/j1939/group_signals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "cli/base/session.h"
#include "cli/dbc/dbc_file.h"
#include "dbc/reader.h"
#include "j1939/client/groups.h"

namespace {

using namespace cansync::cli;

// Of SAE J1939-71: EEC1 (PGN 61444) with SPN 899, 513, 190; ET1 (65262) with SPN 110; and a made up one.
constexpr const char* kFile = R"(VERSION ""
BO_ 2364540158 EEC1: 8 Vector__XXX
 SG_ TorqueMode : 0|4@1+ (1,0) [0|15] "" Vector__XXX
 SG_ ActualTorque : 16|8@1+ (1,-125) [-125|125] "%" Vector__XXX
 SG_ EngineSpeed : 24|16@1+ (0.125,0) [0|8031.875] "rpm" Vector__XXX
BO_ 2566844158 ET1: 8 Vector__XXX
 SG_ Coolant : 0|8@1+ (1,-40) [-40|210] "degC" Vector__XXX
BO_ 2566843907 ET1_of_3: 8 Vector__XXX
 SG_ Coolant : 0|8@1+ (1,-40) [-40|210] "degC" Vector__XXX
BO_ 2365522686 Choice: 3 Vector__XXX
 SG_ Which M : 0|8@1+ (1,0) [0|255] "" Vector__XXX
 SG_ First m1 : 8|8@1+ (1,0) [0|250] "" Vector__XXX
 SG_ Second m2 : 8|16@1- (1,0) [-250|250] "" Vector__XXX
BO_ 291 Narrow: 8 Vector__XXX
 SG_ One : 0|8@1+ (1,0) [0|255] "" Vector__XXX
VAL_ 2364540158 TorqueMode 0 "idle" 15 "unknown" ;
)";

dbc::Database database() {
  dbc::File file = dbc::read_database(kFile);
  EXPECT_TRUE(file.remarks.empty());
  return std::move(file.database);
}

std::string wrong(const std::string& name, const std::vector<std::string>& settings) {
  try {
    (void)encode_group(database(), name, settings);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "taken";
}

TEST(GroupSignals, AGroupIsFoundWhateverItsPriorityAndSource) {
  const j1939::client::Groups all(database());
  ASSERT_NE(all.find(0xF004, 0x21, 255).message, nullptr);
  EXPECT_EQ(all.find(0xF004, 0x21, 255).message->name, "EEC1");
  EXPECT_EQ(all.find(0xFEEE, 0x21, 255).message->name, "ET1");
  EXPECT_EQ(all.find(0xFEEE, 3, 255).message->name, "ET1_of_3") << "that of the very source first";
  EXPECT_EQ(all.find(0xFEEE, 0x21, 255).others, 0u) << "254 stands for any source";
  EXPECT_EQ(all.find(0xFEF1, 0x21, 255).message, nullptr);
}

TEST(GroupSignals, OfSeveralMessagesOfAGroupThatForTheDestinationCounts) {
  const j1939::client::Groups all(
      dbc::read_database("BO_ 2565804065 ToPump: 8 X\n SG_ Speed : 0|16@1+ (0.5,0) [0|0] \"rpm\" X\n"
                         "BO_ 2565832737 ToFan: 8 X\n SG_ Angle : 0|8@1+ (1,-90) [0|0] \"deg\" X\n"
                         "BO_ 2566843904 OfOne: 8 X\n SG_ A : 0|8@1+ (1,0) [0|0] \"\" X\n"
                         "BO_ 2566843905 OfTwo: 8 X\n SG_ A : 0|8@1+ (1,0) [0|0] \"\" X\n")
          .database);
  struct Case {
    j1939::Pgn pgn;
    j1939::Address source;
    j1939::Address destination;
    const char* name;
    std::size_t others;
  };
  const Case cases[] = {
      {0xEF00, 0x21, 0x10, "ToPump", 0}, {0xEF00, 0x21, 0x80, "ToFan", 0},  {0xEF00, 0x33, 0x80, "ToFan", 0},
      {0xEF00, 0x21, 0xFF, "ToPump", 1}, {0xEF00, 0x21, 0x81, "ToPump", 1}, {0xFEEE, 1, 0xFF, "OfTwo", 0},
      {0xFEEE, 7, 0xFF, "OfOne", 1},
  };
  for (const Case& one : cases) {
    const auto found = all.find(one.pgn, one.source, one.destination);
    ASSERT_NE(found.message, nullptr) << one.name;
    EXPECT_EQ(found.message->name, one.name) << int{one.source} << " to " << int{one.destination};
    EXPECT_EQ(found.others, one.others) << int{one.source} << " to " << int{one.destination};
  }
  const std::vector<std::uint8_t> data = {90};
  const auto unclear = all.find(0xFEEE, 7, 0xFF);
  EXPECT_EQ(meaning_of(*unclear.message, j1939::client::read_group(*unclear.message, data), unclear.others),
            "OfOne (or 1 other message of this group): A 90");
}

TEST(GroupSignals, ValuesHaveUnitsAndWhatIsNotAvailableSaysSo) {
  const j1939::client::Groups all(database());
  const dbc::Message& message = *all.find(0xF004, 0, 255).message;
  const std::vector<std::uint8_t> data = {0xF0, 0xFF, 0xFE, 0x80, 0x25, 0xFF, 0xFF, 0xFF};
  EXPECT_EQ(meaning_of(message, j1939::client::read_group(message, data)),
            "EEC1: TorqueMode 0 (idle), ActualTorque error (0xFE), EngineSpeed 1200 rpm");
  const std::vector<std::uint8_t> none(8, 0xFF);
  EXPECT_EQ(
      meaning_of(message, j1939::client::read_group(message, none)),
      "EEC1: TorqueMode 15 (unknown), ActualTorque not available (0xFF), EngineSpeed not available (0xFFFF)");
}

// SAE J1939-71, ranges of transmitted signals: of one, two and four bytes, and of two bits.
TEST(GroupSignals, WhichRawValuesAreNoValues) {
  struct Case {
    unsigned length;
    std::uint64_t raw;
    const char* word;  ///< empty: a value
  };
  const Case cases[] = {
      {8, 0xFA, ""},
      {8, 0xFB, "parameter specific"},
      {8, 0xFC, "reserved"},
      {8, 0xFD, "reserved"},
      {8, 0xFE, "error"},
      {8, 0xFF, "not available"},
      {16, 0xFAFF, ""},
      {16, 0xFB00, "parameter specific"},
      {16, 0xFBFF, "parameter specific"},
      {16, 0xFC00, "reserved"},
      {16, 0xFDFF, "reserved"},
      {16, 0xFE00, "error"},
      {16, 0xFF00, "not available"},
      {32, 0xFAFFFFFF, ""},
      {32, 0xFB000000, "parameter specific"},
      {32, 0xFE000000, "error"},
      {32, 0xFF000000, "not available"},
      {2, 1, ""},
      {2, 2, "error"},
      {2, 3, "not available"},
      {1, 1, ""},
      {3, 7, ""},
      {3, 6, ""},
      {5, 31, ""},
      {5, 30, ""},
      {7, 126, ""},
      {7, 127, "not available"},
      {64, 0xFF00000000000000, ""},
  };
  for (const Case& one : cases) {
    const auto file = dbc::read_database("BO_ 2566844158 A: 8 X\n SG_ S : 0|" + std::to_string(one.length) +
                                         "@1+ (2,0) [0|0] \"\" X\n");
    std::vector<std::uint8_t> data(8);
    for (unsigned i = 0; i < 8; ++i) data[i] = static_cast<std::uint8_t>(one.raw >> (8 * i));
    const auto readings = j1939::client::read_group(file.database.messages().at(0), data);
    ASSERT_EQ(readings.size(), 1u);
    EXPECT_EQ(readings[0].word, one.word) << one.length << " bits, " << one.raw;
    EXPECT_EQ(std::isnan(readings[0].value), *one.word != 0) << one.length << " bits, " << one.raw;
  }
}

TEST(GroupSignals, WhatIsNotGivenIsNotAvailable) {
  const auto message =
      encode_group(database(), "EEC1", std::vector<std::string>{"EngineSpeed=1200", "TorqueMode=idle"});
  EXPECT_EQ(message.pgn, 0xF004u);
  EXPECT_EQ(message.priority, 3);
  EXPECT_EQ(message.destination, 255);
  EXPECT_EQ(message.data, (std::vector<std::uint8_t>{0xF0, 0xFF, 0xFF, 0x80, 0x25, 0xFF, 0xFF, 0xFF}));
}

TEST(GroupSignals, WhatIsNoValueIsGivenInWordsAlone) {
  const auto bytes = [](const std::string& name, const std::vector<std::string>& settings) {
    return encode_group(database(), name, settings).data;
  };
  EXPECT_EQ(bytes("EEC1", {"EngineSpeed=error", "ActualTorque=error", "TorqueMode=not available"}),
            (std::vector<std::uint8_t>{0xFF, 0xFF, 0xFE, 0xFF, 0xFE, 0xFF, 0xFF, 0xFF}));
  EXPECT_EQ(bytes("ET1", {"Coolant=not available"}), std::vector<std::uint8_t>(8, 0xFF));

  const dbc::File file = dbc::read_database(
      "BO_ 2566844158 Free: 8 X\n SG_ Speed : 0|16@1+ (0.125,0) [0|0] \"rpm\" X\n"
      " SG_ Switch : 16|2@1+ (1,0) [0|0] \"\" X\n SG_ Own : 24|8@1+ (1,0) [0|0] \"\" X\n"
      " SG_ Which M : 32|8@1+ (1,0) [0|0] \"\" X\n SG_ Angle : 40|8@1- (1,0) [0|0] \"\" X\n"
      "VAL_ 2566844158 Own 254 \"torn\" 255 \"error\" ;\n");
  const auto said = [&file](const std::string& setting) -> std::string {
    try {
      (void)encode_group(file.database, "Free", std::vector<std::string>{setting});
    } catch (const UsageError& error) {
      return error.what();
    }
    return "taken";
  };
  EXPECT_EQ(
      said("Speed=8160"),
      "--set Speed: found '8160', whose bits 0xFF00 say 'not available' (SAE J1939-71); allowed: a value, or what the "
      "bits say in words, 'not available' or 'error'; DATA takes any bytes");
  for (const char* setting :
       {"Speed=8031.875", "Switch=1", "Own=254", "Own=torn", "Own=error", "Which=255", "Angle=-1"})
    EXPECT_EQ(said(setting), "taken") << setting;
  for (const char* setting : {"Speed=8032", "Switch=2", "Switch=3", "Own=251", "Own=253"})
    EXPECT_NE(said(setting), "taken") << setting;
  EXPECT_EQ(encode_group(file.database, "Free", std::vector<std::string>{"Own=error"}).data[3], 0xFF)
      << "the file's word comes first";
  EXPECT_EQ(said("Angle=error"), "--set Angle: found 'error'; allowed: -128..127");
}

TEST(GroupSignals, AMessageIsForWhomTheFileSays) {
  const dbc::File file = dbc::read_database(
      "BO_ 2565804065 ToPump: 8 X\n SG_ Speed : 0|8@1+ (1,0) [0|0] \"\" X\n"
      "BO_ 2565865249 ToAll: 8 X\n SG_ Speed : 0|8@1+ (1,0) [0|0] \"\" X\n");
  const std::vector<std::string> setting{"Speed=1"};
  EXPECT_EQ(encode_group(file.database, "ToPump", setting).destination, 0x10);
  EXPECT_EQ(encode_group(file.database, "ToAll", setting).destination, 255);
}

TEST(GroupSignals, AChosenSignalBringsItsChoice) {
  const auto message = encode_group(database(), "Choice", std::vector<std::string>{"Second=-2"});
  EXPECT_EQ(message.data, (std::vector<std::uint8_t>{2, 0xFE, 0xFF}));
}

TEST(GroupSignals, WhatIsWrongIsToldWithWhatThereIs) {
  EXPECT_EQ(wrong("EEC2", {"A=1"}), "PGN: found 'EEC2'; allowed: Narrow, EEC1, Choice, ET1_of_3, ET1");
  EXPECT_EQ(wrong("EEC1", {"Speed=1"}),
            "--set: found 'Speed'; allowed: TorqueMode, ActualTorque, EngineSpeed");
  EXPECT_EQ(wrong("EEC1", {"EngineSpeed"}), "--set: found 'EngineSpeed'; allowed: NAME=VALUE");
  EXPECT_EQ(wrong("EEC1", {"EngineSpeed=9000"}),
            "--set EngineSpeed: found '9000'; allowed: 0..8031.875 rpm, 'not available', 'error'");
  EXPECT_EQ(
      wrong("EEC1", {"EngineSpeed=8032"}),
      "--set EngineSpeed: found '8032'; allowed: 0..8031.875 rpm, 'not available', 'error'; these are the limits in the file: where they are "
      "wrong, correct them there");
  EXPECT_EQ(wrong("EEC1", {"EngineSpeed=8031.875"}), "taken") << "the highest value of the file";
  EXPECT_EQ(wrong("EEC1", {"TorqueMode=unknown"}), "taken");
  EXPECT_EQ(
      wrong("Choice", {"First=251"}),
      "--set First: found '251'; allowed: 0..250, 'not available', 'error'; these are the limits in the "
      "file: where they are wrong, correct them there");
  EXPECT_EQ(wrong("EEC1", {"TorqueMode=fast"}),
            "--set TorqueMode: found 'fast'; allowed: 0..15, 'idle', 'unknown', 'not available'");
  EXPECT_EQ(wrong("EEC1", {"EngineSpeed=1", "EngineSpeed=2"}), "--set EngineSpeed: it is given twice");
  EXPECT_EQ(wrong("Narrow", {"One=1"}),
            "PGN: message 'Narrow' has an identifier of 11 bits; allowed: one of 29");
  EXPECT_EQ(wrong("Choice", {"First=1", "Second=2"}),
            "--set First: it cannot be in one message with the others");
}

TEST(GroupSignals, WhatCouldMeanTwoThingsIsRefused) {
  const dbc::File file = dbc::read_database(
      "BO_ 2364540158 Twice: 8 X\n SG_ A : 0|8@1+ (1,0) [0|0] \"\" X\n"
      "BO_ 2566844158 Twice: 8 X\n SG_ A : 0|8@1+ (1,0) [0|0] \"\" X\n"
      "BO_ 2566844414 Mux: 8 X\n SG_ Which M : 0|8@1+ (1,0) [0|0] \"\" X\n SG_ T m0 : 8|8@1+ (1,0) [0|0] \"\" X\n"
      " SG_ T m1 : 16|8@1+ (1,0) [0|0] \"\" X\n SG_ State : 24|8@1+ (1,0) [0|0] \"\" X\n"
      "VAL_ 2566844414 State 0 \"2\" 1 \"1\" 4 \"reserved\" 5 \"reserved\" 6 \"on\" ;\n");
  const auto said = [&file](const std::string& name, const std::string& setting) -> std::string {
    try {
      (void)encode_group(file.database, name, std::vector<std::string>{setting});
    } catch (const UsageError& error) {
      return error.what();
    }
    return "taken";
  };
  EXPECT_EQ(said("Twice", "A=1"),
            "PGN: found 'Twice', which is the name of 2 messages; allowed: a name that is there once");
  EXPECT_EQ(said("Mux", "T=1"),
            "--set: found 'T', which is the name of 2 signals; allowed: a name that is there once");
  EXPECT_EQ(said("Mux", "State=reserved"),
            "--set State: found 'reserved', which is the name of the raw values 4 and 5; allowed: a number");
  EXPECT_EQ(
      said("Mux", "State=2"),
      "--set State: found '2', which is a number and the name of raw value 0; allowed: another form of the number, such as 2e0");
  for (const char* setting : {"State=2e0", "State=2.0", "State=0", "State=1", "State=on"})
    EXPECT_EQ(said("Mux", setting), "taken") << setting;
}

}  // namespace
