// Signals of J1939 by name: groups whatever their priority and source, what is not available, sending.
#include "cli/j1939/group_signals.h"

#include <gtest/gtest.h>

#include <variant>

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
 SG_ Second m2 : 8|16@1- (1,0) [0|250] "" Vector__XXX
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
  ASSERT_NE(all.find(0xF004, 0x21), nullptr);
  EXPECT_EQ(all.find(0xF004, 0x21)->name, "EEC1");
  EXPECT_EQ(all.find(0xFEEE, 0x21)->name, "ET1");
  EXPECT_EQ(all.find(0xFEEE, 3)->name, "ET1_of_3") << "that of the very source first";
  EXPECT_EQ(all.find(0xFEF1, 0x21), nullptr);
}

TEST(GroupSignals, ValuesHaveUnitsAndWhatIsNotAvailableSaysSo) {
  const j1939::client::Groups all(database());
  const dbc::Message& message = *all.find(0xF004, 0);
  const std::vector<std::uint8_t> data = {0xF0, 0xFF, 0xFE, 0x80, 0x25, 0xFF, 0xFF, 0xFF};
  EXPECT_EQ(meaning_of(message, j1939::client::read_group(message, data)),
            "EEC1: TorqueMode 0 (idle), ActualTorque 129 % (error), EngineSpeed 1200 rpm");
  const std::vector<std::uint8_t> none(8, 0xFF);
  EXPECT_EQ(
      meaning_of(message, j1939::client::read_group(message, none)),
      "EEC1: TorqueMode 15 (unknown), ActualTorque 130 % (not available), EngineSpeed 8191.875 rpm (not "
      "available)");
}

TEST(GroupSignals, WhatIsNotGivenIsNotAvailable) {
  const auto message =
      encode_group(database(), "EEC1", std::vector<std::string>{"EngineSpeed=1200", "TorqueMode=idle"});
  EXPECT_EQ(message.pgn, 0xF004u);
  EXPECT_EQ(message.priority, 3);
  EXPECT_EQ(message.destination, 255);
  EXPECT_EQ(message.data, (std::vector<std::uint8_t>{0xF0, 0xFF, 0xFF, 0x80, 0x25, 0xFF, 0xFF, 0xFF}));
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
  EXPECT_EQ(wrong("EEC1", {"EngineSpeed=9000"}), "--set EngineSpeed: found '9000'; allowed: 0..8191.875 rpm");
  EXPECT_EQ(wrong("EEC1", {"TorqueMode=fast"}),
            "--set TorqueMode: found 'fast'; allowed: 0..15, 'idle', 'unknown'");
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
