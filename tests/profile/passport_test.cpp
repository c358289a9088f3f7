// The text of drive passports.
#include "profile/passport.h"

#include <gtest/gtest.h>

#include "profile/hash.h"

namespace profile {
namespace {

Parameter parameter(std::uint16_t number, const std::string& name) {
  Parameter made;
  made.number = number;
  made.name = name;
  made.is_signed = true;
  made.factor = 0.1;
  made.unit = "%";
  return made;
}

Passport example() {
  Passport passport;
  passport.bus = "can0";
  passport.slave = 3;
  passport.slave_name = "the winder";
  passport.profile = "drive";
  passport.profile_hash = "abcdef";
  passport.entries.push_back(passport_entry(parameter(12, "torque-offset"), 0xFFFF));
  Parameter type = parameter(100, "device-type");
  type.identity = Identity::type;
  type.access = Access::read_only;
  passport.entries.push_back(passport_entry(type, 44));
  Parameter moving = parameter(310, "torque");
  moving.is_volatile = true;
  moving.access = Access::read_only;
  moving.unit = "";
  passport.entries.push_back(passport_entry(moving, std::nullopt));
  return passport;
}

/// A text with a checksum that fits.
std::string signed_text(const std::string& lines) {
  return lines + "sha256 " + sha256(lines) + "\n";
}

constexpr const char* kHead =
    "# CANsync drive passport, version 1; docs/passport.md\nbus b\nslave 1 s\nprofile p h\n";

std::string problem_of(const std::string& lines) {
  const PassportReading reading = parse_passport(signed_text(kHead + lines));
  if (!reading.passport) return std::to_string(reading.line) + ": " + reading.problem;
  EXPECT_EQ(reading.changed, !reading.left_out.empty());
  return reading.left_out.empty() ? "" : reading.left_out.front();
}

TEST(Passport, EndsOfLinesAndAMarkOfOtherSystemsAreNoChange) {
  std::string text = "\xEF\xBB\xBF";
  for (const char c : passport_text(example())) text += c == '\n' ? std::string("\r\n") : std::string(1, c);
  const PassportReading reading = parse_passport(text);
  ASSERT_TRUE(reading.passport) << reading.problem;
  EXPECT_EQ(*reading.passport, example());
  EXPECT_FALSE(reading.changed);
  EXPECT_TRUE(reading.left_out.empty());
}

TEST(Passport, ALineWithAControlCharacterIsLeftOut) {
  EXPECT_NE(problem_of("taken 2026\r1\n")
                .find("in line 5: found a control character; allowed: text; the line is left out"),
            std::string::npos);
}

TEST(Passport, AFileOfAnotherKindIsNamed) {
  EXPECT_NE(parse_passport("{\"a\": 1}").problem.find("this is no passport: it looks like JSON; allowed: "),
            std::string::npos);
}

TEST(Passport, IsTextWithOneParameterALine) {
  EXPECT_EQ(
      passport_text(example()),
      signed_text("# CANsync drive passport, version 1; docs/passport.md\n"
                  "bus can0\n"
                  "slave 3 the winder\n"
                  "profile drive abcdef\n"
                  "type       100 device-type                  word               44            4.4 %        "
                  "read-only\n"
                  "parameter   12 torque-offset                word            65535           -0.1 %        "
                  "read-write\n"
                  "parameter  310 torque                       word                -              - -        "
                  "read-only,volatile\n"));
}

TEST(Passport, IsReadBackAsItWas) {
  Passport passport = example();
  const PassportReading reading = parse_passport(passport_text(passport));
  ASSERT_TRUE(reading.passport) << reading.problem;
  EXPECT_EQ(*reading.passport, passport);
  EXPECT_FALSE(reading.changed);
  passport.taken = "2026-01-02T03:04:05Z";
  passport.slave_name = "";
  EXPECT_EQ(*parse_passport(passport_text(passport)).passport, passport);
}

TEST(Passport, OneValueChangesItsLineAndTheChecksumAlone) {
  const auto lines_of = [](const std::string& text) {
    std::vector<std::string> lines;
    for (std::size_t at = 0; at < text.size(); at = text.find('\n', at) + 1)
      lines.push_back(text.substr(at, text.find('\n', at) - at));
    return lines;
  };
  Passport changed = example();
  changed.entries[0] = passport_entry(parameter(12, "torque-offset"), 7);
  const auto before = lines_of(passport_text(example()));
  const auto after = lines_of(passport_text(changed));
  ASSERT_EQ(before.size(), after.size());
  std::size_t different = 0;
  for (std::size_t i = 0; i < before.size(); ++i) different += before[i] != after[i] ? 1 : 0;
  EXPECT_EQ(different, 2U);
}

TEST(Passport, AChangeShowsInTheChecksum) {
  std::string text = passport_text(example());
  text.replace(text.find("65535"), 5, "65534");
  const PassportReading reading = parse_passport(text);
  ASSERT_TRUE(reading.passport);
  EXPECT_TRUE(reading.changed);
  EXPECT_EQ(reading.passport->entries[0].raw, 65534U);
}

TEST(Passport, WhatIsNoneIsToldWithItsLine) {
  EXPECT_NE(parse_passport("hello\n").problem.find("this is no passport"), std::string::npos);
  const std::string kGood = "parameter 1 a word 5 5 - read-write\n";
  EXPECT_EQ(problem_of(kGood), "");
  EXPECT_NE(problem_of(kGood + kGood).find("no parameter can be used"), std::string::npos);
  EXPECT_EQ(
      problem_of(kGood + "colour red\n"),
      "6: found 'colour'; allowed: bus, slave, profile, taken, type, unit, parameter, sha256; the line is left out");
  EXPECT_EQ(problem_of(kGood + "bus again\n"), "6: allowed: 'bus NAME' once; the line is left out");
  EXPECT_EQ(problem_of(kGood + "slave 2 x\n"),
            "6: allowed: 'slave NUMBER NAME' once, with a number 0..31; the line is left out");
  EXPECT_EQ(problem_of(kGood + "parameter 1 a word 5 5 -\n"),
            "6: allowed: seven words: NUMBER NAME FORMAT RAW VALUE UNIT ACCESS; the line is left out");
  EXPECT_EQ(problem_of(kGood + "parameter 4096 a word 5 5 - read-write\n"),
            "6: found '4096'; allowed: a number 0..4095; the line is left out");
  EXPECT_EQ(problem_of(kGood + "parameter 1 A word 5 5 - read-write\n"),
            "6: found 'A'; allowed: a name of lower-case letters, digits and '-'; the line is left out");
  EXPECT_EQ(problem_of(kGood + "parameter 1 a byte 5 5 - read-write\n"),
            "6: found 'byte'; allowed: word, doubleword; the line is left out");
  EXPECT_EQ(problem_of(kGood + "parameter 1 a word 65536 5 - read-write\n"),
            "6: found '65536'; allowed: a raw value 0..65535, or -; the line is left out");
  EXPECT_EQ(
      problem_of(kGood + "parameter 1 a word 5 5 - rw\n"),
      "6: found 'rw'; allowed: read-only or read-write, with ,volatile behind or not; the line is left out");
  EXPECT_EQ(
      parse_passport(signed_text("# CANsync drive passport, version 1; docs/passport.md\nbus b\n")).problem,
      "a line 'profile NAME HASH' is missing");
}

TEST(Passport, WhatIsDamagedCostsItsOwnLinesAndCountsAsChanged) {
  const std::string whole = passport_text(example());
  const PassportReading cut = parse_passport(whole.substr(0, whole.find("sha256")));
  ASSERT_TRUE(cut.passport);
  EXPECT_TRUE(cut.changed);
  EXPECT_NE(cut.left_out.at(0).find("is not complete"), std::string::npos);
  EXPECT_EQ(cut.passport->entries, example().entries);
  const PassportReading more = parse_passport(whole + "more\n");
  EXPECT_TRUE(more.changed);
  EXPECT_NE(more.left_out.at(0).find("behind the checksum"), std::string::npos);
  const PassportReading twice = parse_passport(signed_text(
      std::string(kHead) +
      "parameter 1 a word 5 5 - read-write\nparameter 2 b word 6 6 - read-write\nparameter 1 a word 7 7 - read-write\n"));
  ASSERT_TRUE(twice.passport);
  ASSERT_EQ(twice.passport->entries.size(), 1U);
  EXPECT_EQ(twice.passport->entries[0].number, 2);
  EXPECT_EQ(twice.left_out.at(0), "8: parameter 1 is there twice; all its lines are left out");
}

}  // namespace
}  // namespace profile
