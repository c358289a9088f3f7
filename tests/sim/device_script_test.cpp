#include "sim/device_script.h"

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "can/candump.h"
#include "sim/line.h"
#include "sim/metronome.h"

namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

can::Frame frame(const std::string& text) {
  return std::get<can::Frame>(can::parse_candump_frame(text));
}

sim::DeviceSettings good(std::string_view text) {
  sim::DeviceScript script = sim::parse_device_script(text, "device.toml");
  for (const config::Problem& error : script.errors) ADD_FAILURE() << to_string(error);
  return std::move(script.device);
}

std::string wrong(std::string_view text) {
  const sim::DeviceScript script = sim::parse_device_script(text, "d.toml");
  return script.errors.empty() ? "no error" : to_string(script.errors[0]);
}

std::optional<can::Frame> answer(sim::ScriptedDevice& device, const std::string& asked) {
  const can::Frame question = frame(asked);
  if (!device.accepts(question)) return std::nullopt;
  const auto sent = device.on_frame(question, can::Time{0});
  if (!sent) return std::nullopt;
  return sent->frame;
}

TEST(DeviceScript, EveryKeyIsRead) {
  const sim::DeviceSettings device = good(R"(
[[answer]]
to = "601#4000"
mask = 0x7F0
data_mask = "FF0F"
frame = "581#43"
copy_data = true
after_ms = 1.5
count = 2
[[periodic]]
frame = "00000181#0011"
every_ms = 10
phase_ms = 2
counting_byte = 1
)");
  ASSERT_EQ(device.answers.size(), 1u);
  EXPECT_EQ(device.answers[0].to, frame("601#4000"));
  EXPECT_EQ(device.answers[0].mask, 0x7F0u);
  EXPECT_EQ(device.answers[0].data_mask[0], 0xFF);
  EXPECT_EQ(device.answers[0].data_mask[1], 0x0F);
  EXPECT_EQ(device.answers[0].frame, frame("581#43"));
  EXPECT_TRUE(device.answers[0].copy_data);
  EXPECT_EQ(device.answers[0].after, microseconds(1500));
  EXPECT_EQ(device.answers[0].count, 2u);
  ASSERT_EQ(device.periods.size(), 1u);
  EXPECT_EQ(device.periods[0].frame, frame("00000181#0011"));
  EXPECT_EQ(device.periods[0].every, milliseconds(10));
  EXPECT_EQ(device.periods[0].phase, milliseconds(2));
  EXPECT_EQ(device.periods[0].counting, 1);
}

TEST(DeviceScript, WhatIsWrongIsToldWithItsPlace) {
  EXPECT_EQ(
      wrong("[[answer]]\nto = \"601#\"\nframe = \"8FF#\"\n"),
      "d.toml:3:9: frame is \"8FF#\"; allowed: \"identifier#data\" (at character 1: identifier 8FF is over 7FF; "
      "larger ones are written with 8 digits)");
  EXPECT_EQ(wrong("[[answer]]\nframe = \"1FF#\"\n").substr(0, 35), "d.toml:1:1: the key to is missing: ");
  EXPECT_NE(wrong("[[answer]]\nto = \"601#\"\nframe = \"1FF#\"\nfly = 1\n")
                .find("4:1: fly is unknown here; allowed: to, "),
            std::string::npos);
  EXPECT_NE(wrong("[answer]\nto = \"601#\"\n").find("without double brackets"), std::string::npos);
  EXPECT_NE(wrong("other = 1\n").find("1:1: other is unknown here"), std::string::npos);
  EXPECT_NE(wrong("[[periodic]]\nframe = \"1FF#\"\n").find("every_ms is missing"), std::string::npos);
  EXPECT_NE(wrong("[[periodic]]\nframe = \"1FF#\"\nevery_ms = 0\n")
                .find("3:12: every_ms is 0; allowed: milliseconds, 0.1 to"),
            std::string::npos);
  EXPECT_NE(wrong("[[periodic]]\nframe = \"1FF#00\"\nevery_ms = 1\ncounting_byte = 1\n")
                .find("a byte that the frame has"),
            std::string::npos);
  EXPECT_NE(wrong("[[answer]]\nto = \"601#00\"\nframe = \"1FF#\"\ndata_mask = \"FFFF\"\n")
                .find("as many bytes as `to` has"),
            std::string::npos);
  EXPECT_NE(wrong("[[answer]]\nto = \"601#00\"\nframe = \"1FF#\"\ncount = 0\n").find("count is 0"),
            std::string::npos);
  EXPECT_NE(wrong("[[answer]]\nto = \"20000001#00\"\nframe = \"1FF#\"\n").find("a data or remote frame"),
            std::string::npos);
  EXPECT_NE(wrong("[[answer\n").find("not valid TOML"), std::string::npos);
}

TEST(DeviceScript, ATableWithAnErrorIsLeftOutAlone) {
  const sim::DeviceScript script = sim::parse_device_script(
      "[[answer]]\nto = \"601#\"\n[[answer]]\nto = \"602#\"\nframe = \"582#\"\n"
      "[[periodic]]\nframe = \"181#\nevery_ms = 1\n[[periodic]]\nframe = \"182#\"\nevery_ms = 2\n",
      "d.toml");
  ASSERT_EQ(script.device.answers.size(), 1u);
  EXPECT_EQ(script.device.answers[0].frame, frame("582#"));
  ASSERT_EQ(script.device.periods.size(), 1u);
  EXPECT_EQ(script.device.periods[0].frame, frame("182#"));
  EXPECT_FALSE(script.refused());
  ASSERT_EQ(script.errors.size(), 2u);
  EXPECT_EQ(script.errors[0].where.line, 1u);
  EXPECT_EQ(script.errors[1].where.line, 7u);
}

TEST(DeviceScript, AtMost256TablesOfAKind) {
  std::string text;
  for (unsigned i = 0; i < 257; ++i) text += "[[periodic]]\nframe = \"181#\"\nevery_ms = 1\n";
  const sim::DeviceScript script = sim::parse_device_script(text, "d.toml");
  EXPECT_EQ(script.device.periods.size(), 256u);
  ASSERT_EQ(script.errors.size(), 1u);
  EXPECT_EQ(to_string(script.errors[0]), "d.toml:769:1: found 257 tables [[periodic]]; allowed: 256");
}

TEST(ScriptedDevice, TheFirstThatFitsAnswers) {
  sim::ScriptedDevice device(good(R"(
[[answer]]
to = "601#40"
frame = "581#01"
count = 1
[[answer]]
to = "601#40"
frame = "581#02"
[[answer]]
to = "601#R"
frame = "581#03"
[[answer]]
to = "700#00"
mask = 0x700
data_mask = "0F"
frame = "080#"
copy_data = true
)"));
  EXPECT_EQ(answer(device, "601#40AA"), frame("581#01"));
  EXPECT_EQ(answer(device, "601#40AA"), frame("581#02"));
  EXPECT_EQ(answer(device, "601#41"), std::nullopt);
  EXPECT_EQ(answer(device, "601#"), std::nullopt) << "too short to have the byte";
  EXPECT_EQ(answer(device, "601#R"), frame("581#03"));
  EXPECT_EQ(answer(device, "00000601#40"), std::nullopt) << "another width";
  EXPECT_EQ(answer(device, "7FF#F0AA"), frame("080#F0AA"));
  EXPECT_EQ(answer(device, "7FF#F1"), std::nullopt);
  EXPECT_EQ(answer(device, "6FF#F0"), std::nullopt);
}

TEST(ScriptedDevice, SendsByItselfAtItsPeriodsOnALine) {
  std::vector<std::unique_ptr<sim::Node>> nodes;
  nodes.push_back(std::make_unique<sim::ScriptedDevice>(good(
      "[[periodic]]\nframe = \"181#FE\"\nevery_ms = 1\nphase_ms = 0.5\ncounting_byte = 0\n[[periodic]]\nframe = \"182#\"\nevery_ms = 2\n")));
  sim::Line line({}, std::move(nodes));
  std::vector<std::uint8_t> counted;
  unsigned other = 0;
  while (line.now() < milliseconds(4)) {
    line.wait_until(milliseconds(4));
    for (can::ReceivedFrame received; line.receive(received);) {
      if (received.frame.id == 0x181)
        counted.push_back(received.frame.data[0]);
      else
        ++other;
    }
  }
  EXPECT_EQ(counted, (std::vector<std::uint8_t>{0xFE, 0xFF, 0, 1}));
  EXPECT_EQ(other, 2u);
}

TEST(ScriptedDevice, WhatNobodyAskedForInTimeIsLeftOut) {
  sim::ScriptedDevice device(good("[[periodic]]\nframe = \"181#\"\nevery_ms = 1\n"));
  (void)device.on_join(can::Time{0});
  EXPECT_EQ(device.next_time(), can::Time{0});
  EXPECT_TRUE(device.on_time(milliseconds(10)).transmission);
  EXPECT_EQ(device.next_time(), milliseconds(11));
  EXPECT_FALSE(device.on_time(milliseconds(10)).transmission);
}

TEST(Metronome, CountsTheIntervalsOfFaultsOnALineWithoutSync) {
  sim::LineSettings settings;
  settings.faults = {{.kind = sim::FaultKind::inject, .from = 2, .to = 3, .frame = frame("123#01")}};
  std::vector<std::unique_ptr<sim::Node>> nodes;
  nodes.push_back(std::make_unique<sim::Metronome>(milliseconds(1)));
  sim::Line line(settings, std::move(nodes));
  std::vector<can::Time> starts;
  while (line.now() < milliseconds(6)) {
    line.wait_until(milliseconds(6));
    for (can::ReceivedFrame received; line.receive(received);)
      starts.push_back(std::chrono::floor<milliseconds>(received.end));
  }
  EXPECT_EQ(starts, (std::vector<can::Time>{milliseconds(2), milliseconds(3)}));
}

}  // namespace
