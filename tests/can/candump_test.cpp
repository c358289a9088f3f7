#include "can/candump.h"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <ctime>
#include <initializer_list>
#include <random>
#include <string>
#include <string_view>
#include <variant>

#include "flagged_frames.h"

namespace {

using can::Frame;
using can::test::data_frame;
using can::test::error;
using can::test::extended;
using can::test::remote;
using std::chrono::microseconds;

std::string written(microseconds time, std::string_view interface, const Frame& frame) {
  std::array<char, can::kCandumpLineLimit> buffer{};
  const std::size_t size = can::write_candump_line(time, interface, frame, buffer);
  return {buffer.data(), size};
}

TEST(CandumpWriter, LinesAsCandumpWritesThem) {
  EXPECT_EQ(written(microseconds(350), "can0", data_frame(0x17F, {0x0D, 0xAB})),
            "(0000000000.000350) can0 17F#0DAB\n");
  EXPECT_EQ(written(microseconds(1'700'000'000'123'456), "line1", data_frame(0x010, {})),
            "(1700000000.123456) line1 010#\n");
  EXPECT_EQ(written(microseconds(0), "can0", extended(data_frame(0x123, {1}))),
            "(0000000000.000000) can0 00000123#01\n");
  EXPECT_EQ(written(microseconds(0), "can0", remote(data_frame(0x123, {}))),
            "(0000000000.000000) can0 123#R\n");
  EXPECT_EQ(written(microseconds(0), "can0", extended(remote(data_frame(0x12345, {0, 0, 0, 0})))),
            "(0000000000.000000) can0 00012345#R4\n");
  EXPECT_EQ(written(microseconds(0), "can0", extended(remote(data_frame(0x123, {})))),
            "(0000000000.000000) can0 00000123#R\n");
  EXPECT_EQ(written(microseconds(0), "can0", error(data_frame(0x008, {0, 0, 0, 0, 0, 0, 0, 0}))),
            "(0000000000.000000) can0 20000008#0000000000000000\n");
}

TEST(CandumpWriter, LongestLineFits) {
  const std::string line =
      written(microseconds(INT64_MAX), "a_name_that_is_far_too_long",
              extended(data_frame(0x1FFFFFFF, {255, 255, 255, 255, 255, 255, 255, 255})));
  EXPECT_EQ(line, "(9223372036854.775807) a_name_that_is_ 1FFFFFFF#FFFFFFFFFFFFFFFF\n");
}

TEST(CandumpParser, ReadsWhatTheWriterWrites) {
  std::mt19937 random(3);
  for (int n = 0; n < 10'000; ++n) {
    Frame frame;
    const auto kind = random() % 5;
    frame.error = kind == 4;
    frame.extended = !frame.error && kind % 2 == 1;
    frame.remote = !frame.error && kind >= 2;
    frame.id = static_cast<std::uint32_t>(random()) & (kind % 2 == 1 || frame.error ? 0x1FFFFFFFu : 0x7FFu);
    if (n % 8 == 0) frame.id &= 0x7FFu;
    frame.dlc = static_cast<std::uint8_t>(random() % 9);
    if (!frame.remote) {
      for (unsigned i = 0; i < frame.dlc; ++i) frame.data[i] = static_cast<std::uint8_t>(random());
    }
    const microseconds time(random());
    const auto parsed = can::parse_candump_line(written(time, "can0", frame));
    ASSERT_TRUE(std::holds_alternative<can::CandumpLine>(parsed))
        << std::get<can::CandumpError>(parsed).message;
    const auto& line = std::get<can::CandumpLine>(parsed);
    EXPECT_EQ(line.time, time);
    EXPECT_EQ(line.interface, "can0");
    EXPECT_EQ(line.frame, frame);
  }
}

TEST(CandumpParser, ReadsEachKindAsItWasWritten) {
  for (const Frame& frame : can::test::four_kinds()) {
    const std::string line = written(microseconds(1), "can0", frame);
    const auto parsed = can::parse_candump_line(line);
    ASSERT_TRUE(std::holds_alternative<can::CandumpLine>(parsed)) << line;
    EXPECT_EQ(std::get<can::CandumpLine>(parsed).frame, frame) << line;
  }
}

// The lines are those of candump(1) with -t a, -x, -a and without a stamp.
TEST(CandumpParser, ReadsWhatCandumpShowsOnAScreen) {
  const auto parsed = [](std::string_view text) {
    const auto line = can::parse_candump_line(text);
    if (const auto* wrong = std::get_if<can::CandumpError>(&line))
      ADD_FAILURE() << text << ": " << wrong->message;
    return std::holds_alternative<can::CandumpLine>(line) ? std::get<can::CandumpLine>(line)
                                                          : can::CandumpLine();
  };
  const can::CandumpLine stamped = parsed(" (1700000000.123456)  can0  123   [3]  11 22 A3\n");
  EXPECT_EQ(stamped.time, microseconds(1'700'000'000'123'456));
  EXPECT_EQ(stamped.interface, "can0");
  EXPECT_EQ(stamped.frame, data_frame(0x123, {0x11, 0x22, 0xA3}));
  EXPECT_EQ(parsed("  can0  12345678   [1]  AB").frame, extended(data_frame(0x12345678, {0xAB})));
  EXPECT_EQ(parsed("  can0  123   [0] ").frame, data_frame(0x123, {}));
  EXPECT_EQ(parsed("  can0  123   [0]  remote request").frame, remote(data_frame(0x123, {})));
  EXPECT_EQ(parsed("  can0  RX - -  123   [2]  41 42   'AB'").frame, data_frame(0x123, {0x41, 0x42}));
  EXPECT_EQ(parsed("  can0  20000008   [8]  00 00 00 00 00 00 00 00   ERRORFRAME").frame,
            error(data_frame(0x008, {0, 0, 0, 0, 0, 0, 0, 0})));
  const auto wrong = [](std::string_view text) {
    const auto line = can::parse_candump_line(text);
    return std::holds_alternative<can::CandumpError>(line) ? std::get<can::CandumpError>(line).message : "";
  };
  EXPECT_EQ(wrong("  can0  123#45  [2]  11 22"), "expected a space behind the identifier, found '#'");
  EXPECT_NE(wrong("  can0  20000008  [4]  remote request").find("two hexadecimal digits"), std::string::npos)
      << "an error frame is no request";
  EXPECT_NE(wrong("  can0  123  [0]  remote request of").find("the end of the line"), std::string::npos);
  EXPECT_NE(wrong("  can0  123  [12]  11 22 33 44 55 66 77 88 99 00 11 22").find("CAN FD frames ('[12]')"),
            std::string::npos);
  EXPECT_NE(wrong("  can0  321  [0003]  (07|03:0000ABCD)  0A 0B 0C").find("CAN XL frames ('[0003]')"),
            std::string::npos);
  EXPECT_EQ(parsed("  can0  123  {F}  11 22 33 44 55 66 77 88").frame,
            parsed("  can0  123  [8]  11 22 33 44 55 66 77 88").frame)
      << "candump -8";
  EXPECT_NE(wrong("  can0  123  [9]  11").find("[0] to [8]"), std::string::npos);
  EXPECT_NE(wrong("  can0  123  [3]  11 22").find("a byte"), std::string::npos);
  EXPECT_NE(wrong("  can0  123  [1]  11 22").find("the end of the line"), std::string::npos);
}

TEST(CandumpParser, StampsMayHaveNanosecondsOrADate) {
  const auto time_of = [](std::string_view line) {
    const auto parsed = can::parse_candump_line(line);
    if (const auto* wrong = std::get_if<can::CandumpError>(&parsed)) ADD_FAILURE() << wrong->message;
    return std::holds_alternative<can::CandumpLine>(parsed) ? std::get<can::CandumpLine>(parsed).time
                                                            : microseconds(-1);
  };
  EXPECT_EQ(time_of("(1594172461.968006789) can0 123#00"), microseconds(1'594'172'461'968'006));
  std::tm date = {};
  date.tm_year = 109;
  date.tm_mon = 1;
  date.tm_mday = 13;
  date.tm_hour = 23;
  date.tm_min = 31;
  date.tm_sec = 30;
  date.tm_isdst = -1;
  EXPECT_EQ(time_of(" (2009-02-13 23:31:30.000001)  can0  123   [1]  11"),
            microseconds(std::mktime(&date) * 1'000'000 + 1));
  for (const std::string_view wrong : {"(1.1234567) can0 123#", "(2009-02-13 23:31.000001) can0 123#"})
    EXPECT_TRUE(std::holds_alternative<can::CandumpError>(can::parse_candump_line(wrong))) << wrong;
}

// As cansend takes them: lib.h of can-utils has the notation.
TEST(CandumpParser, BytesMayHaveDotsBetweenThemAndAnEighthALengthCode) {
  const auto parsed = [](std::string_view text) { return can::parse_candump_frame(text); };
  EXPECT_EQ(std::get<can::Frame>(parsed("123#11.22.A3")), data_frame(0x123, {0x11, 0x22, 0xA3}));
  EXPECT_EQ(std::get<can::Frame>(parsed("123#1122.A3")), data_frame(0x123, {0x11, 0x22, 0xA3}));
  EXPECT_EQ(std::get<can::Frame>(parsed("123#1122334455667788_F")),
            data_frame(0x123, {0x11, 0x22, 0x33, 0x44, 0x55, 0x66, 0x77, 0x88}));
  EXPECT_EQ(std::get<can::Frame>(parsed("123#R8_F")), std::get<can::Frame>(parsed("123#R8")));
  for (const std::string_view wrong : {"123#.11", "123#11.", "123#11..22", "123#1.122", "123#11_9",
                                       "123#1122334455667788_8", "123#R7_F", "123#R8_8"})
    EXPECT_TRUE(std::holds_alternative<can::CandumpError>(parsed(wrong))) << wrong;
}

TEST(CandumpParser, TakesLowerCaseAndADirection) {
  const auto parsed = can::parse_candump_line("(1.000002)  vcan0 58f#aB T\r\n");
  ASSERT_TRUE(std::holds_alternative<can::CandumpLine>(parsed));
  const auto& line = std::get<can::CandumpLine>(parsed);
  EXPECT_EQ(line.time, microseconds(1'000'002));
  EXPECT_EQ(line.frame, data_frame(0x58F, {0xAB}));
}

struct Wrong {
  std::string_view line;
  std::size_t column;
  std::string_view message;  // a part of it
};

class CandumpParserErrors : public testing::TestWithParam<Wrong> {};

TEST_P(CandumpParserErrors, NameColumnAndCause) {
  const auto parsed = can::parse_candump_line(GetParam().line);
  ASSERT_TRUE(std::holds_alternative<can::CandumpError>(parsed));
  const auto& wrong = std::get<can::CandumpError>(parsed);
  EXPECT_EQ(wrong.column, GetParam().column) << wrong.message;
  EXPECT_NE(wrong.message.find(GetParam().message), std::string::npos) << wrong.message;
}

INSTANTIATE_TEST_SUITE_P(Lines, CandumpParserErrors,
                         testing::Values(Wrong{"", 1, "'(' before the time stamp, found the end"},
                                         Wrong{"1.0 can0 123#", 1, "found '1'"},
                                         Wrong{"(x.000000) can0 123#", 2, "the seconds"},
                                         Wrong{"(1,000000) can0 123#", 3, "'.' after"},
                                         Wrong{"(1.00000) can0 123#", 9, "six digits"},
                                         Wrong{"(1.0000000) can0 123#", 11, "or nine of nanoseconds"},
                                         Wrong{"(1.000000)", 11, "interface name"},
                                         Wrong{"(1.000000) name_of_16_chars_ 123#", 12, "1 to 15 characters"},
                                         Wrong{"(1.000000) can0", 16, "found 0 digits"},
                                         Wrong{"(1.000000) can0 12#", 17, "found 2 digits"},
                                         Wrong{"(1.000000) can0 123456789#", 17, "or more digits"},
                                         Wrong{"(1.000000) can0 800#", 17, "over 7FF"},
                                         Wrong{"(1.000000) can0 40000000#", 17, "over 1FFFFFFF"},
                                         Wrong{"(1.000000) can0 123", 20, "'#' after the identifier"},
                                         Wrong{"(1.000000) can0 123##0", 21, "CAN FD"},
                                         Wrong{"(1.000000) can0 07321#80:03:0000ABCD#0A", 17, "CAN XL"},
                                         Wrong{"(1.000000) can0 321#80:03:0000ABCD#0A", 17, "CAN XL"},
                                         Wrong{"(1.000000) can0 123#0", 22, "second hexadecimal"},
                                         Wrong{"(1.000000) can0 123#0G", 22, "found 'G'"},
                                         Wrong{"(1.000000) can0 123#x0", 21, "found 'x'"},
                                         Wrong{"(1.000000) can0 123#001122334455667788", 37, "more than 8"},
                                         Wrong{"(1.000000) can0 123#R9", 22, "length digit"},
                                         Wrong{"(1.000000) can0 123#00 Q", 24, "found 'Q'"},
                                         Wrong{"(1.000000) can0 123#00 R 1", 25, "the end of the line"}));

}  // namespace
