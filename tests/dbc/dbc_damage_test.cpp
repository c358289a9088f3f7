// Files that are not as the format has them: what is undamaged is used, what is damaged has a remark with its
// place.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "dbc/encode.h"
#include "dbc/reader.h"
#include "support/damaged_files.h"

namespace dbc {
namespace {

using Bytes = std::array<std::uint8_t, 8>;

/// The one signal of message 291 in a file with these lines around it.
const Signal* speed_of(const File& file) {
  const Message* message = file.database.find(291, false);
  if (message == nullptr || message->signals.empty()) return nullptr;
  return message->signals.front().name == "Speed" ? &message->signals.front() : nullptr;
}

constexpr std::string_view kMotor = "BO_ 291 Motor: 8 ECU\n SG_ Speed : 0|16@1+ (1,0) [0|0] \"rpm\" X\n";

File read_beside(std::string_view before, std::string_view behind = "") {
  return read_database(std::string(before) + std::string(kMotor) + std::string(behind));
}

struct Case {
  std::string_view what;
  std::string_view before;
  std::string_view behind;
  std::string_view remark;  ///< words of the first one; empty: the file is read completely
};

TEST(DbcDamage, OtherStatementsCostNothingOfAMessage) {
  const Case cases[] = {
      {"a comment that ends with a backslash", "CM_ \"made from C:\\line\\\";\n", "", ""},
      {"a quotation mark in a comment", "CM_ SG_ 291 Speed \"for the 5\" pipe\";\n", "", ""},
      {"a comment that does not end", "CM_ \"cut off\n", "", "a text that does not end"},
      {"a comment of two lines", "CM_ \"one;\nBO_ 1 which is none\";\n", "", ""},
      {"two statements in a line", "CM_ \"a\"; CM_ \"b\";\n", "", ""},
      {"value names of an unknown signal", "", "VAL_ 291 Nope 1 \"x\" ;\n",
       "found 'Nope'; allowed: a signal of message"},
      {"value names of an unknown message", "", "VAL_ 7 Speed 1 \"x\" ;\n",
       "allowed: the number of a message"},
      {"a kind of number of an unknown signal", "", "SIG_VALTYPE_ 291 Nope : 1;\n", "found 'Nope'"},
      {"a kind of number that does not fit", "", "SIG_VALTYPE_ 291 Speed : 1;\n", "stays a whole number"},
      {"ranges of an unknown signal", "", "SG_MUL_VAL_ 291 Nope Speed 1-1;\n", "found 'Nope'"},
      {"ranges of what is no multiplexor", "", "SG_MUL_VAL_ 291 Speed Speed 1-1;\n", "a multiplexor (M)"},
      {"an attribute with a mark", "BA_ \"Path\" \"C:\\dir\\\";\n", "", ""},
      {"a word that is none", "<<<<<<< HEAD\n", "", "allowed: a statement of a DBC file"},
      {"a word that is none, behind signals", "", "<<<<<<< HEAD\n",
       "allowed: a signal (SG_), or a statement"},
      {"a line that begins with #", "# BO_ 7 Old: 8 \"ECU;\n", "", "found '#'; allowed: a statement"},
      {"the same, alone", "#\n", "", "found '#'; allowed: a statement"},
      {"limits of which one is none", "", " SG_ B : 16|8@1+ (1,0) [0|Inf] \"\" X\n", ""},
      {"limits that its bits cannot reach", "", " SG_ B : 16|8@1+ (1,0) [300|400] \"\" X\n",
       "found the limits 300..400; allowed: within 0..255"},
      {"a message cut in its header", "BO_ 5 Oth\n SG_ A : 0|8@1+ (1,0) [0|0] \"\" X\n", "", "allowed: ':'"},
      {"a signal of no message", " SG_ A : 0|8@1+ (1,0) [0|0] \"\" X\n", "", "below its message"},
      {"a message that comes twice", "", kMotor, "the number of an earlier message"},
      {"a mark of UTF-8", "\xEF\xBB\xBF", "", ""},
      {"a list of statements", "NS_ :\n\tCM_\n\tBO_TX_BU_ \n\nBS_:\n\nBU_: A B\n     C\n", "", ""},
  };
  for (const Case& one : cases) {
    const File file = read_beside(one.before, one.behind);
    ASSERT_NE(speed_of(file), nullptr) << one.what;
    EXPECT_EQ(speed_of(file)->unit, "rpm") << one.what;
    if (one.remark.empty()) {
      EXPECT_TRUE(file.remarks.empty()) << one.what << ": " << file.remarks.front().text;
    } else {
      ASSERT_EQ(file.remarks.size(), 1u)
          << one.what << (file.remarks.empty() ? "" : file.remarks.back().text);
      EXPECT_NE(file.remarks[0].text.find(one.remark), std::string::npos) << file.remarks[0].text;
    }
  }
}

TEST(DbcDamage, ASignalThatIsWrongCostsItselfAlone) {
  const Case cases[] = {
      {"a length of 0", "S : 0|0@1+ (1,0) [0|0] \"\" X", "", "1..14280"},
      {"beyond the message", "S : 60|8@1+ (1,0) [0|0] \"\" X", "",
       "does not fit into the 8 bytes of message A"},
      {"an order of bytes", "S : 0|8@2+ (1,0) [0|0] \"\" X", "", "order of bytes"},
      {"a unit that does not end", "S : 0|8@1+ (1,0) [0|0] \"unending X", "", "does not end"},
      {"a text that is no whole bytes", "S : 0|137@1+ (1,0) [0|0] \"\" X", "", "whole bytes"},
      {"a decimal comma", "S : 0|8@1+ (0,5,0) [0|0] \"\" X", "", "allowed: ')'"},
      {"cut off", "S : 0|8@1+ (1,0) [0|0", "", "allowed: ']'"},
      {"a multiplexor that is not there", "S m1 : 0|8@1+ (1,0) [0|0] \"\" X", "", "no multiplexor"},
      {"something behind it", "S : 0|8@1+ (1,0) [0|0] \"\" X ) SG_", "", "the end of the line"},
  };
  for (const Case& one : cases) {
    const File file = read_database("BO_ 1 A: 8 X\n SG_ B : 0|8@1+ (1,0) [0|0] \"\" X\n SG_ " +
                                    std::string(one.before) + "\n SG_ E : 8|8@1+ (1,0) [0|0] \"\" X\n");
    ASSERT_EQ(file.database.messages().size(), 1u) << one.what;
    const auto& signals = file.database.messages()[0].signals;
    ASSERT_GE(signals.size(), 2u) << one.what;
    EXPECT_EQ(signals.front().name, "B") << one.what;
    EXPECT_EQ(signals.back().name, "E") << one.what;
    ASSERT_EQ(file.remarks.size(), 1u) << one.what;
    EXPECT_EQ(file.remarks[0].line, 3u) << one.what;
    EXPECT_NE(file.remarks[0].text.find(one.remark), std::string::npos) << file.remarks[0].text;
  }
}

TEST(DbcDamage, ALineAmongSignalsCostsItselfAlone) {
  for (const std::string_view line :
       {"# SG_ Old : 16|8@1+ (1,0) [0|0] \"\" X", "#", "(1,0) [0|0]", "SIG A"}) {
    const File file = read_beside("", std::string(line) + "\n SG_ B : 16|8@1+ (1,0) [0|0] \"\" X\n");
    ASSERT_NE(speed_of(file), nullptr) << line;
    EXPECT_EQ(file.database.messages()[0].signals.size(), 2u) << line;
    ASSERT_EQ(file.remarks.size(), 1u) << line;
    EXPECT_EQ(std::make_pair(file.remarks[0].line, file.remarks[0].column),
              std::make_pair(std::size_t{3}, std::size_t{1}))
        << line;
  }
}

TEST(DbcDamage, WhatToolsLeaveOutIsNoDamage) {
  const std::string_view lines[] = {
      "BO_ 291 Motor: 8\n SG_ Speed : 0|16@1+ (1,0) [0|0] \"rpm\" X\n",
      "BO_ 291 Motor: 8 ECU\n SG_ Speed : 0|16@1+ (1,0) [0|0] \"rpm\"\n",
      "BO_ 291 Motor: 8 ECU\n SG_ Speed : 0|16@1+ (1,0) [0|0] \"rpm\" A B,C\r\n",
      "BO_ 291 Motor: 8 ECU\n SG_ Speed : 0|16@1+ (1,0) [0|1.#INF] \"rpm\" X\n",
      "BO_ 291 Motor: 8 ECU SG_ Speed : 0|16@1+ (1,0) [0|0] \"rpm\" X",
  };
  for (const std::string_view text : lines) {
    const File file = read_database(text);
    ASSERT_NE(speed_of(file), nullptr) << text;
    EXPECT_EQ(speed_of(file)->unit, "rpm") << text;
    EXPECT_TRUE(file.remarks.empty()) << text << file.remarks.front().text;
  }
}

TEST(DbcDamage, IdentifiersOf29BitsWithoutBit31AreTakenAndSaid) {
  const File file = read_beside("BO_ 316495015 Other: 8 ECU\n SG_ First : 0|8@1+ (1,0) [0|0] \"\" X\n",
                                "VAL_ 316495015 First 1 \"one\" ;\n");
  ASSERT_NE(file.database.find(316495015, true), nullptr);
  EXPECT_EQ(file.database.find(316495015, true)->signals[0].words.size(), 1u);
  ASSERT_EQ(file.remarks.size(), 1u);
  EXPECT_NE(file.remarks[0].text.find("without bit 31; taken for the identifier 0x12DD54A7"),
            std::string::npos)
      << file.remarks[0].text;
}

TEST(DbcDamage, FilesWithoutAMessageAreRefusedWithWhatTheyLookLike) {
  const std::pair<std::string_view, std::string_view> files[] = {
      {"", "no message (BO_) is in this file"},
      {"version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 1\n", "git lfs pull"},
      {"<NetworkDefinition xmlns=\"http://kayak.2codeornot2code.org/1.0\">", "KCD"},
      {"{\"messages\": []}", "JSON"},
      {std::string_view("\xFF\xFE"
                        "B\0O\0",
                        6),
       "UTF-16"},
  };
  for (const auto& [text, words] : files)
    EXPECT_NE(read_database(text).refused.find(words), std::string::npos)
        << words << ": " << read_database(text).refused;
}

TEST(DbcDamage, TextsAreInOneLineWithoutTheirEscapes) {
  const File file =
      read_beside("",
                  "VAL_ 291 Speed 1 \"state \\\"run\\\"\" 2 \"not used  \r\nDefault value\" 3 \"5\" pipe\" "
                  "4 \"\x80 \xFC\" 5 \"C:\\\" ;\n");
  const Signal* speed = speed_of(file);
  ASSERT_NE(speed, nullptr);
  using Words = std::vector<std::pair<std::int64_t, std::string>>;
  EXPECT_EQ(
      speed->words,
      (Words{
          {1, "state \"run\""}, {2, "not used   Default value"}, {3, "5\" pipe"}, {4, "€ ü"}, {5, "C:\\"}}));
  EXPECT_TRUE(file.remarks.empty()) << file.remarks.front().text;
}

TEST(DbcDamage, ListsOfNamesOfASignalAreOne) {
  const File file = read_beside(
      "", "VAL_ 291 Speed 1.0 \"one\" 2 \"two\" ;\nVAL_ 291 Speed 2 \"two\" 3 \"three\" 1 \"uno\" ;\n");
  const Signal* speed = speed_of(file);
  ASSERT_NE(speed, nullptr);
  using Words = std::vector<std::pair<std::int64_t, std::string>>;
  EXPECT_EQ(speed->words, (Words{{1, "one"}, {2, "two"}, {3, "three"}}));
  ASSERT_EQ(file.remarks.size(), 1u);
  EXPECT_EQ(file.remarks[0].text, "1 of signal Speed is named twice; the first name, 'one', counts");
  EXPECT_EQ(file.remarks[0].line, 4u);
}

// Files have 255 or -1 for eight bits of ones, whether the signal is signed or not.
TEST(DbcDamage, NamedValuesAreThoseOfTheBits) {
  const File file = read_database(
      "BO_ 291 M: 8 X\n SG_ Signed : 0|8@1- (1,0) [0|0] \"\" X\n SG_ Not : 8|8@1+ (1,0) [0|0] \"\" X\n"
      " SG_ Float : 16|32@1- (1,0) [0|0] \"\" X\n"
      "VAL_ 291 Signed 255 \"none\" -2 \"two\" 511 \"beyond\" ;\nVAL_ 291 Not -1 \"none\" 2 \"two\" ;\n"
      "VAL_ 291 Float -3 \"off\" ;\nSIG_VALTYPE_ 291 Float : 1;\n");
  const Message& message = file.database.messages()[0];
  const auto words = [&](std::uint8_t both) {
    // The last four are -3.0 (IEEE 754).
    const auto readings = read_signals(message, std::array<std::uint8_t, 6>{both, both, 0, 0, 0x40, 0xC0});
    std::string all;
    for (const Reading& reading : readings) all += std::string(reading.word) + ",";
    return all;
  };
  EXPECT_EQ(words(0xFF), "none,none,off,");
  EXPECT_EQ(words(0xFE), "two,,off,");
  EXPECT_EQ(words(0x02), ",two,off,");
  EXPECT_EQ(raw_of(message.signals[0], "none"), 0xFFu);
  EXPECT_EQ(raw_of(message.signals[0], "beyond"), std::nullopt);
  EXPECT_EQ(raw_of(message.signals[2], "off"), 0xC0400000u);
}

TEST(DbcDamage, AFactorOf0IsTakenAs1AndSaid) {
  const File file = read_database("BO_ 291 Motor: 8 ECU\n SG_ Speed : 0|16@1+ (0,5) [0|0] \"rpm\" X\n");
  const Signal* speed = speed_of(file);
  ASSERT_NE(speed, nullptr);
  EXPECT_EQ(speed->factor, 1.0);
  EXPECT_EQ(speed->offset, 5.0);
  ASSERT_EQ(file.remarks.size(), 1u);
  EXPECT_NE(file.remarks[0].text.find("a factor of 0"), std::string::npos) << file.remarks[0].text;
}

TEST(DbcDamage, LongNamesAreTheNames) {
  const File file = read_beside(
      "BA_DEF_ SG_ \"SystemSignalLongSymbol\" STRING ;\n",
      "BA_ \"SystemSignalLongSymbol\" SG_ 291 Speed \"Speed_of_the_motor_that_has_a_long_name\";\n"
      "BA_ \"SystemMessageLongSymbol\" BO_ 291 \"Motor_that_has_a_long_name_in_this_file\";\n"
      "VAL_ 291 Speed 513 \"on\" ;\n");
  ASSERT_NE(file.database.find(291, false), nullptr);
  const Message& message = *file.database.find(291, false);
  EXPECT_EQ(message.name, "Motor_that_has_a_long_name_in_this_file");
  EXPECT_EQ(message.signals[0].name, "Speed_of_the_motor_that_has_a_long_name");
  EXPECT_EQ(message.signals[0].words.size(), 1u);
  EXPECT_TRUE(file.remarks.empty());
}

std::string names_in(const File& file, const Bytes& data) {
  std::string names;
  for (const Reading& reading : read_signals(file.database.messages().at(0), data))
    names += reading.signal->name + " " + value_text(reading) + ",";
  return names;
}

// SAE J1979 as car tools describe it: the service chooses the PID, the PID the value.
TEST(DbcDamage, MultiplexorsBelowMultiplexors) {
  const File file = read_database(
      "BO_ 291 Answer: 8 ECU\n SG_ Service M : 0|8@1+ (1,0) [0|0] \"\" X\n SG_ Pid m1M : 8|8@1+ (1,0) [0|0] \"\" X\n"
      " SG_ Rpm m12 : 23|16@0+ (0.25,0) [0|0] \"rpm\" X\n SG_ Speed m13 : 16|8@1+ (1,0) [0|0] \"km/h\" X\n"
      "SG_MUL_VAL_ 291 Pid Service 1-1;\nSG_MUL_VAL_ 291 Rpm Pid 12-12;\nSG_MUL_VAL_ 291 Speed Pid 13-15, 20-20;\n");
  ASSERT_TRUE(file.remarks.empty()) << file.remarks.front().text;
  EXPECT_EQ(names_in(file, {1, 12, 0x1A, 0xF8}), "Service 1,Pid 12,Rpm 1726,");
  EXPECT_EQ(names_in(file, {1, 14, 50}), "Service 1,Pid 14,Speed 50,");
  EXPECT_EQ(names_in(file, {1, 16, 50}), "Service 1,Pid 16,");
  EXPECT_EQ(names_in(file, {2, 12, 0x1A, 0xF8}), "Service 2,") << "the PID is not there, nor what it chooses";
  const Message& message = file.database.messages()[0];
  Bytes data = {};
  choose(message, message.signals[3], data);
  EXPECT_EQ(data, (Bytes{1, 13})) << "the chain of multiplexors chooses it";
  data = {1, 20};
  choose(message, message.signals[3], data);
  EXPECT_EQ(data, (Bytes{1, 20})) << "what chooses it already stays";
}

TEST(DbcDamage, SeveralMultiplexorsNeedTheirNames) {
  const std::string two =
      "BO_ 291 A: 8 ECU\n SG_ One M : 0|8@1+ (1,0) [0|0] \"\" X\n SG_ Two M : 8|8@1+ (1,0) [0|0] \"\" X\n"
      " SG_ V m1 : 16|8@1+ (1,0) [0|0] \"\" X\n";
  const File unclear = read_database(two);
  ASSERT_EQ(unclear.remarks.size(), 1u);
  EXPECT_NE(unclear.remarks[0].text.find("signal V: no SG_MUL_VAL_ names its multiplexor"),
            std::string::npos);
  EXPECT_EQ(names_in(unclear, {1, 1, 5}), "One 1,Two 1,");
  const File clear = read_database(two + "SG_MUL_VAL_ 291 V Two 1-1;\n");
  EXPECT_EQ(names_in(clear, {0, 1, 5}), "One 0,Two 1,V 5,");
  const File circle = read_database(
      "BO_ 291 A: 8 ECU\n SG_ One m1M : 0|8@1+ (1,0) [0|0] \"\" X\n SG_ Two m1M : 8|8@1+ (1,0) [0|0] \"\" X\n"
      " SG_ V m1 : 16|8@1+ (1,0) [0|0] \"\" X\n SG_ W : 24|8@1+ (1,0) [0|0] \"\" X\n"
      "SG_MUL_VAL_ 291 One Two 1-1;\nSG_MUL_VAL_ 291 Two One 1-1;\nSG_MUL_VAL_ 291 V Two 1-1;\n");
  EXPECT_EQ(circle.remarks.size(), 3u);
  EXPECT_EQ(names_in(circle, {1, 1, 5, 7}), "W 7,");
}

TEST(DbcDamage, TextsOfOver64Bits) {
  const File file = read_database(
      "BO_ 1 A: 20 ECU\n SG_ Vin : 0|136@1+ (1,0) [0|0] \"\" X\n"
      " SG_ Big : 143|72@0+ (1,0) [0|0] \"\" X\n SG_ End : 152|8@1+ (1,0) [0|0] \"\" X\n");
  ASSERT_EQ(file.remarks.size(), 1u) << "Big is beyond the message";
  std::vector<std::uint8_t> data(20);
  const std::string_view vin = "WVWZZZ1JZXW000001";
  std::copy(vin.begin(), vin.end(), data.begin());
  data[19] = 9;
  const auto readings = read_signals(file.database.messages()[0], data);
  ASSERT_EQ(readings.size(), 2u);
  EXPECT_EQ(readings[0].text, vin);
  EXPECT_EQ(value_text(readings[0]), vin);
  EXPECT_EQ(readings[1].value, 9.0);
  EXPECT_EQ(raw_of(file.database.messages()[0].signals[0], 1.0), std::nullopt) << "a text is no number";
  const auto part = read_signals(file.database.messages()[0], std::span(data).first(3));
  ASSERT_EQ(part.size(), 1u) << "texts of J1939 are shorter than the file says";
  EXPECT_EQ(part[0].text, "WVW");
  EXPECT_TRUE(read_signals(file.database.messages()[0], {}).empty());
}

TEST(DbcDamage, ValuesHaveTheDigitsThatGiveThemAgain) {
  const File file = read_database(
      "BO_ 1 A: 8 E\n SG_ U : 0|64@1+ (1,0) [0|0] \"\" X\nBO_ 2 B: 8 E\n SG_ S : 0|64@1- (1,0) [0|0] \"\" X\n"
      "BO_ 3 C: 8 E\n SG_ T : 0|48@1+ (0.001,0) [0|0] \"\" X\nBO_ 4 D: 8 E\n SG_ F : 0|32@1- (1,0) [0|0] \"\" X\n"
      "BO_ 5 G: 8 E\n SG_ H : 0|16@1+ (.25,-.5) [0|0] \"\" X\nBO_ 6 I: 8 E\n SG_ J : 0|56@1+ (1,.5) [0|0] \"\" X\nSIG_VALTYPE_ 4 F : 1;\n");
  ASSERT_TRUE(file.remarks.empty()) << file.remarks.front().text;
  const auto shown = [&file](std::size_t message, const Bytes& data) {
    const auto readings = read_signals(file.database.messages().at(message), data);
    const std::string text = value_text(readings.at(0));
    EXPECT_EQ(raw_of_digits(*readings[0].signal, text), readings[0].raw) << text;
    return text;
  };
  EXPECT_EQ(shown(0, {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF}), "18446744073709551615");
  EXPECT_EQ(shown(1, {0, 0, 0, 0, 0, 0, 0, 0x80}), "-9223372036854775808");
  EXPECT_EQ(shown(2, {0xCB, 0x04, 0xFB, 0x71, 0x1F, 0x01}), "1234567890.123");
  EXPECT_EQ(shown(3, {0xCD, 0xCC, 0xCC, 0x3D}), "0.1") << "IEEE 754: 0x3DCCCCCD";
  EXPECT_EQ(shown(4, {3, 0}), "0.25");
  EXPECT_EQ(shown(5, {0xC4, 0x00, 0xAC, 0xD8, 0x9E, 0x67, 0x01, 0x00}), "395406914355396.5")
      << "the offset of half a step is there";
}

// ---- damage by chance ----

struct Line {
  std::string text;
  unsigned message;  ///< which message it belongs to
};

/// A file of messages 1..n, each with a header, signals and names of values.
std::vector<Line> lines_of(unsigned messages, std::mt19937& dice) {
  std::vector<Line> lines;
  for (unsigned m = 1; m <= messages; ++m) {
    lines.push_back({"BO_ " + std::to_string(m) + " M" + std::to_string(m) + ": 8 ECU", m});
    for (unsigned s = 0; s < 4; ++s)
      lines.push_back({" SG_ S" + std::to_string(s) + " : " + std::to_string(16 * s) + "|16@1" +
                           (dice() % 2 ? "+" : "-") + " (0.5," + std::to_string(dice() % 9) + ") [0|0] \"u" +
                           std::to_string(s) + "\" ECU",
                       m});
  }
  for (unsigned m = 1; m <= messages; ++m) {
    lines.push_back(
        {"CM_ SG_ " + std::to_string(m) + " S0 \"comment \\\"" + std::to_string(m) + "\\\"\";", m});
    lines.push_back({"VAL_ " + std::to_string(m) + " S1 0 \"off\" 1 \"on\" ;", m});
  }
  return lines;
}

std::string joined(const std::vector<Line>& lines) {
  std::string text = "VERSION \"\"\n\nNS_ :\n\tCM_\n\nBS_:\n\nBU_: ECU\n\n";
  for (const Line& line : lines) text += line.text + "\n";
  return text;
}

/// Messages in words, all that counts of them.
std::string in_words(const Message& message) {
  std::string text = message.name + " " + std::to_string(message.length);
  for (const Signal& one : message.signals) {
    text += ";" + one.name + one.unit + " " + std::to_string(one.start) + " " + std::to_string(one.length) +
            " " + std::to_string(one.offset) + " " + std::to_string(static_cast<int>(one.kind));
    for (const auto& [raw, word] : one.words) text += " " + std::to_string(raw) + word;
  }
  return text;
}

TEST(DbcDamage, WhatIsUndamagedIsReadAsWithoutDamage) {
  constexpr unsigned kMessages = 6;
  const unsigned files = test::damaged_files(2000);
  unsigned remarked = 0;
  for (unsigned seed = 0; seed < files; ++seed) {
    std::mt19937 dice(seed);
    std::vector<Line> lines = lines_of(kMessages, dice);
    const File whole = read_database(joined(lines));
    ASSERT_TRUE(whole.remarks.empty()) << whole.remarks.front().text;
    const std::size_t at = dice() % lines.size();
    const unsigned damaged = lines[at].message;
    std::string& line = lines[at].text;
    // Damage may make another message of a header, or leave its signals to the message before.
    const bool header = line.starts_with("BO_");
    switch (dice() % 4) {
      case 0:  // cut
        line.resize(dice() % line.size());
        break;
      case 1:  // a character of another kind
        line[dice() % line.size()] = "\"\\;:M\x80 0"[dice() % 8];
        break;
      case 2:  // doubled in itself
        line += line;
        break;
      default:  // a piece is missing
        line.erase(dice() % line.size(), 1 + dice() % 4);
    }
    const File file = read_database(joined(lines));
    remarked += file.remarks.empty() ? 0 : 1;
    for (unsigned m = 1; m <= kMessages; ++m) {
      if (m == damaged || header) continue;
      const Message* message = file.database.find(m, false);
      ASSERT_NE(message, nullptr) << seed << ": " << line;
      EXPECT_EQ(in_words(*message), in_words(*whole.database.find(m, false))) << seed << ": " << line;
    }
  }
  EXPECT_GT(remarked, files * 2 / 5) << "most damage is seen";
}

}  // namespace
}  // namespace dbc
