#include "signals/signal_table.h"

#include <gtest/gtest.h>

#include <array>
#include <string>

namespace signals {
namespace {

constexpr std::string_view kTable = R"(
[[message]]
name = "Motor"
identifier = 0x123
length = 8
[[message]]
name = "Engine"
pgn = 0xF004
[[signal]]
message = "Motor"
name = "Speed"
start = 0
length = 16
factor = 0.125
offset = -10
unit = "rpm"
[[signal]]
message = "Motor"
name = "Torque"
start = 16
length = 8
kind = "signed"
unit = "°C"
[[signal]]
message = "Motor"
name = "Mode"
start = 24
length = 4
chooses = true
values = ["1 run", "2 stop"]
[[signal]]
message = "Motor"
name = "Big"
start = 39
length = 12
big_endian = true
chosen_by = 1
[[signal]]
message = "Motor"
name = "Other"
start = 32
length = 8
chosen_by = 2
[[signal]]
message = "Engine"
name = "Ratio"
start = 0
length = 32
kind = "float32"
)";

dbc::Database table(std::string_view text = kTable) {
  SignalTable read = read_signal_table(text, "t.toml");
  EXPECT_TRUE(read.problems.empty()) << config::problems_text(read.problems);
  return std::move(read.database);
}

std::string problems(std::string_view text) {
  return config::problems_text(read_signal_table(text, "t.toml").problems);
}

/// A message with one signal, whose last line is `line`.
std::string with(std::string_view line) {
  return "[[message]]\nname = \"M\"\nidentifier = 1\nlength = 2\n[[signal]]\nmessage = \"M\"\nname = \"S\"\n" +
         std::string(line);
}

TEST(SignalTable, SignalsAreThoseThatTheTableDescribes) {
  const dbc::Database names = table();
  const dbc::Message* motor = names.find(0x123, false);
  ASSERT_NE(motor, nullptr);
  EXPECT_EQ(motor->name, "Motor");
  // By hand: 16#0150 * 0.125 - 10, 16#F0 signed, mode 1, and 16#ABC from bit 7 of byte 4 on.
  const std::array<std::uint8_t, 8> data = {0x50, 0x01, 0xF0, 0x01, 0xAB, 0xC0, 0, 0};
  const auto readings = dbc::read_signals(*motor, data);
  ASSERT_EQ(readings.size(), 4u) << "Other is not chosen";
  EXPECT_EQ(readings[0].signal->unit, "rpm");
  EXPECT_DOUBLE_EQ(readings[0].value, 32.0);
  EXPECT_DOUBLE_EQ(readings[1].value, -16.0);
  EXPECT_EQ(readings[1].signal->unit, "°C");
  EXPECT_EQ(readings[2].word, "run");
  EXPECT_EQ(readings[3].raw, 0xABCu);
}

TEST(SignalTable, AGroupStandsForAnySourceAndHasTheDefaultPriority) {
  const dbc::Database names = table();
  const dbc::Message* engine = names.find(0x18F004FE, true);
  ASSERT_NE(engine, nullptr);
  EXPECT_EQ(engine->length, 8u) << "without a length 8 bytes";
  const std::array<std::uint8_t, 8> data = {0x00, 0x00, 0xC0, 0x3F};  // IEEE 754: 1.5
  EXPECT_DOUBLE_EQ(dbc::read_signals(*engine, data).at(0).value, 1.5);
}

TEST(SignalTable, AGroupForOneNodeStandsForAnyDestination) {
  const dbc::Database names = table("[[message]]\nname = \"Command\"\npgn = 0xEF00\n");
  EXPECT_NE(names.find(0x18EFFFFE, true), nullptr);
}

TEST(SignalTable, WhatIsWrongIsToldWithItsPlace) {
  const auto tells = [](std::string_view text, std::string_view words) {
    const std::string found = problems(text);
    EXPECT_NE(found.find(words), std::string::npos) << found;
  };
  tells("x", "t.toml:1");
  tells("[bus]\n", "allowed: [[message]], [[signal]]");
  tells("[[message]]\nname = \"M\"\n", "identifier");
  tells("[[message]]\nname = \"M\"\nidentifier = 0x800\n", "t.toml:3:14: message.identifier");
  tells("[[message]]\nname = \"M\"\nidentifier = 1\npgn = 1\n", "found beside identifier");
  tells("[[message]]\nname = \"M\"\npgn = 0xEA05\n",
        "found 0xEA05; allowed below 0xF000: one that ends in 00");
  tells("[[message]]\nname = \"M\"\nidentifier = 1\n[[message]]\nname = \"N\"\nidentifier = 1\n",
        "each once");
  tells("[[message]]\nname = \"M\"\nidentifier = 1\n[[message]]\nname = \"M\"\nidentifier = 2\n", "t.toml:5");
  tells("[[signal]]\nmessage = \"M\"\nname = \"S\"\nstart = 0\nlength = 1\n", "the name of a [[message]]");
  tells(with("start = 0\n"), "length");
  tells(with("start = 9\nlength = 8\n"), "8 bits from bit 9 on do not fit into the 2 bytes of the message");
  tells(with("start = 0\nlength = 65\n"), "1..64");
  tells(with("start = 0\nlength = 8\nkind = \"float32\"\n"), "allowed with this kind: 32");
  tells(with("start = 0\nlength = 8\nfactor = 0\n"), "other than 0");
  tells(with("start = 0\nlength = 8\ncolour = 1\n"), "colour");
  tells(
      with(
          "start = 0\nlength = 8\nchooses = true\n[[signal]]\nmessage = \"M\"\nname = \"S\"\nstart = 8\nlength = 8\n"
          "chooses = true\n"),
      "a second time in this message");
}

TEST(SignalTable, WhatIsWrongCostsItselfAlone) {
  const SignalTable read = read_signal_table(
      "[[message]]\nname = \"A\"\nidentifier = 1\n"
      "[[message]]\nname = \"B\"\nidentifier = 2\ncolour = 3\n"
      "[[message]]\nname = \"C\"\nidentifier = 3\nlength =\n"
      "[[signal]]\nmessage = \"A\"\nname = \"Good\"\nstart = 0\nlength = 8\n"
      "[[signal]]\nmessage = \"A\"\nname = \"Bad\"\nstart = 8\nlength = 8\nfactr = 0.1\n"
      "[[signal]]\nmessage = \"B\"\nname = \"Lost\"\nstart = 0\nlength = 8\n",
      "t.toml");
  ASSERT_EQ(read.database.messages().size(), 1u);
  ASSERT_EQ(read.database.messages()[0].signals.size(), 1u);
  EXPECT_EQ(read.database.messages()[0].signals[0].name, "Good");
  std::string lines;
  for (const config::Problem& problem : read.problems) lines += std::to_string(problem.where.line) + " ";
  EXPECT_EQ(lines, "7 11 22 24 ");
}

TEST(SignalTable, WhatASignalThatIsLeftOutWouldChooseIsLeftOutToo) {
  const SignalTable read = read_signal_table(
      "[[message]]\nname = \"A\"\nidentifier = 1\n"
      "[[signal]]\nmessage = \"A\"\nname = \"Which\"\nstart = 0\nlength = 99\nchooses = true\n"
      "[[signal]]\nmessage = \"A\"\nname = \"Chosen\"\nstart = 8\nlength = 8\nchosen_by = 1\n"
      "[[signal]]\nmessage = \"A\"\nname = \"Always\"\nstart = 16\nlength = 8\n",
      "t.toml");
  ASSERT_EQ(read.database.messages().size(), 1u);
  ASSERT_EQ(read.database.messages()[0].signals.size(), 1u);
  EXPECT_EQ(read.database.messages()[0].signals[0].name, "Always");
  EXPECT_EQ(read.problems.size(), 2u);
}

}  // namespace
}  // namespace signals
