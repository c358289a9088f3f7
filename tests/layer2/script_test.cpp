#include "layer2/script.h"

#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <vector>

#include "can/flagged_frames.h"

namespace layer2 {
namespace {

using can::test::data_frame;
using can::test::extended;
using can::test::remote;
using std::chrono::milliseconds;
using Kind = ScriptCommand::Kind;

/// "LINE:COLUMN" of the only problem.
std::string place_of(const Script& script) {
  EXPECT_EQ(script.problems.size(), 1u);
  if (script.problems.empty()) return "";
  return std::to_string(script.problems[0].line) + ":" + std::to_string(script.problems[0].column);
}

TEST(Script, L10EveryCommandIsRead) {
  const Script script = parse_script(
      "// reset, then the SYNC timer\n"
      "Send 0x0 2 0x81 0\n"
      "\n"
      "  wait 500 // until they are up\r\n"
      "FETCH 0x701 1\n"
      "Fetch 0x702\n"
      "Start 1\n"
      "Stop 16");
  ASSERT_TRUE(script.problems.empty()) << script.problems[0].text;
  can::Frame asked = remote(data_frame(0x701, {0}));
  const std::vector<ScriptCommand> wanted = {
      {Kind::send, data_frame(0, {0x81, 0}), 0},      {Kind::wait, {}, 500}, {Kind::send, asked, 0},
      {Kind::send, remote(data_frame(0x702, {})), 0}, {Kind::start, {}, 1},  {Kind::stop, {}, 16}};
  EXPECT_EQ(script.commands, wanted);
}

TEST(Script, L10WhatIsWrongIsToldWithLineAndColumn) {
  const std::pair<const char*, const char*> wrong[] = {
      {"Wait 1\nSendd 1 0", "2:1"},
      {"Send", "1:5"},
      {"Send 0x800 0", "1:6"},
      {"Send 0x1 9", "1:10"},
      {"Send 0x1 2 1", "1:10"},
      {"Send 0x1 1 0x100", "1:12"},
      {"Send 0x1 1 1 1", "1:10"},
      {"Fetch 0x1 1 1", "1:13"},
      {"Start 0", "1:7"},
      {"Start 17", "1:7"},
      {"Stop x", "1:6"},
      {"\n\n Wait 65536", "3:7"},
      {"Wait 0", "1:6"},
      {"Wait 1 2", "1:8"},
      {"Send 0x1 0x1 0xG", "1:14"},
      {"Send 80 0", "1:6"},
      {"Wait 99999999999999999999", "1:6"},
      {"Send 0x123456789 0", "1:6"},
  };
  for (const auto& [text, place] : wrong) EXPECT_EQ(place_of(parse_script(text)), place) << text;
  EXPECT_EQ(parse_script("Go\nWait 1\nWait x").problems.size(), 2u);
}

TEST(Script, L10ANumberThatMayBeMeantTwoWaysIsRefusedUntilItIsSaidWhich) {
  const Script refused = parse_script("Send 80 0");
  ASSERT_EQ(refused.problems.size(), 1u);
  EXPECT_NE(refused.problems[0].text.find("script.numbers"), std::string::npos);
  EXPECT_EQ(parse_script("Send 80 1 10", {false, ScriptNumbers::decimal}).commands.at(0).frame,
            data_frame(80, {10}));
  EXPECT_EQ(parse_script("Send 80 1 10", {false, ScriptNumbers::hexadecimal}).commands.at(0).frame,
            data_frame(0x80, {0x10}));
  EXPECT_EQ(parse_script("Start 10", {false, ScriptNumbers::hexadecimal}).commands.at(0).number, 10);
}

TEST(Script, L1TheWidthIsThatOfTheProject) {
  EXPECT_EQ(parse_script("Send 0x18FEF100 1 7", {.extended = true}).commands.at(0).frame,
            extended(data_frame(0x18FEF100, {7})));
  EXPECT_EQ(place_of(parse_script("Send 0x20000000 0", {.extended = true})), "1:6");
}

TEST(Script, L9AHundredLinesWithACommand) {
  std::string text;
  for (int i = 0; i < 100; ++i) text += "// comment\nWait 1\n";
  EXPECT_TRUE(parse_script(text).problems.empty());
  EXPECT_EQ(parse_script(text).commands.size(), 100u);
  EXPECT_EQ(place_of(parse_script(text + "Wait 1")), "201:1");
}

TEST(ScriptRunner, L10WaitsItsTimeBetweenCommands) {
  const Script script = parse_script("Send 1 0\nWait 20\nStart 2\nWait 5");
  ScriptRunner runner;
  EXPECT_FALSE(runner.next(Time{0}));
  runner.begin(script);
  EXPECT_EQ(runner.next(milliseconds(1))->frame, data_frame(1, {}));
  EXPECT_EQ(runner.next(milliseconds(3))->frame, data_frame(1, {}));  // not done yet
  EXPECT_EQ(runner.next_deadline(), Time::max());
  runner.done();
  EXPECT_FALSE(runner.next(milliseconds(4)));
  EXPECT_EQ(runner.next_deadline(), milliseconds(24));
  EXPECT_FALSE(runner.next(milliseconds(24) - Time{1}));
  EXPECT_EQ(runner.next(milliseconds(24))->number, 2);
  runner.done();
  EXPECT_FALSE(runner.next(milliseconds(24)));
  EXPECT_TRUE(runner.runs());
  EXPECT_FALSE(runner.next(milliseconds(29)));
  EXPECT_FALSE(runner.runs());
}

}  // namespace
}  // namespace layer2
