#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "cli/app/application.h"
#include "cli/cansync/trace_text.h"
#include "cli/trace/trace_source.h"

namespace cansync::cli {
namespace {

can::CandumpLine line(const std::string& text) {
  const auto parsed = can::parse_candump_line(text);
  if (const auto* error = std::get_if<can::CandumpError>(&parsed)) {
    ADD_FAILURE() << text << ": " << error->message;
    return {};
  }
  return std::get<can::CandumpLine>(parsed);
}

/// Bytes after the interface in a log line, and what they say: sections 5 to 8 of the protocol.
struct Golden {
  const char* frame;
  const char* text;
};

TEST(TraceText, SaysEveryTelegramInWords) {
  // One after the other on one line: answers are understood by the command before them.
  const std::vector<Golden> frames{
      {"010#0F00000001003412", "CC           -  broadcast to slaves 0-3: control word 0x1234"},
      {"010#FFFFFFFF02010000", "CC           -  broadcast to slaves 0-31: action 2, byte 0x01, word 0x0000"},
      {"107#0100020003000400",
       "WRC1         7  reference values, asks slave 7: words 0x0001 0x0002 0x0003 0x0004"},
      {"1FF#34120000", "WRC2         -  reference values, asks nobody: words 0x1234 0x0000"},
      {"307#CDAB", "RDC1         7  actual values: word 0xABCD"},
      {"39F#", "RDC2        31  actual values: no words"},
      {"503#712D0000", "CC           3  read parameter 301"},
      {"583#012D01800000", "RC           3  parameter 301 = 32769 (0x8001, word)"},
      {"503#73FC0500", "CC           3  read parameter 1020, sub-slave 5"},
      {"583#03FC785634120500",
       "RC           3  parameter 1020 = 305419896 (0x12345678, doubleword), sub-slave 5"},
      {"503#640A0000", "CC           3  read parameter 1034 element 6"},
      {"503#74E80A000000", "CC           3  write parameter 1256 = 10 (0x000A, word)"},
      {"583#44E8", "RC           3  parameter 1256: busy, to be asked again"},
      {"583#04E80000", "RC           3  parameter 1256: written"},
      {"503#74E8FFFFFFFF0000", "CC           3  write parameter 1256 = 4294967295 (0xFFFFFFFF, doubleword)"},
      {"583#24E8FDFF0000", "RC           3  parameter 1256: error 0xFFFD, value above the maximum"},
      {"504#912C000100000000", "CC           4  begin upload of 300 bytes from 0x00000100"},
      {"584#812C", "RC           4  transfer accepted, length 300"},
      {"504#A000", "CC           4  upload: asks for bytes from 0"},
      {"584#8000010203040506", "RC           4  upload: bytes from 0: 01 02 03 04 05 06"},
      {"504#B126", "CC           4  upload: asks for bytes from 294 (last)"},
      {"504#D00C000200000000", "CC           4  begin download of 12 bytes to 0x00000200"},
      {"504#E000AABBCCDDEEFF", "CC           4  download: bytes from 0: AA BB CC DD EE FF"},
      {"584#8000", "RC           4  download: took bytes from 0"},
      {"504#F006AABBCCDDEEFF", "CC           4  download: bytes from 6 (last): AA BB CC DD EE FF"},
      {"584#A0060401", "RC           4  transfer, 6: error 0x0104, transfer not possible"},
      {"504#9000000000000000", "CC           4  cancel transfer"},
  };
  TraceText text;
  for (const Golden& golden : frames) {
    const auto told = text.describe(line(std::string("(1.000000) can0 ") + golden.frame));
    EXPECT_EQ(trace_line(told), std::string("         1.000000         -  ") + golden.text) << golden.frame;
  }
}

TEST(TraceText, AnswersWithoutTheirCommandAreToldAsFarAsTheyGo) {
  TraceText text;
  EXPECT_EQ(text.describe(line("(1.000000) can0 583#012D01800000")).words,
            "parameter 301 = 32769 (0x8001, word)");
  EXPECT_EQ(text.describe(line("(1.000000) can0 583#012D0000")).words, "parameter 301: written");
  EXPECT_EQ(text.describe(line("(1.000000) can0 583#8006")).words, "transfer, 6: accepted");
}

TEST(TraceText, TimesCountFromTheNewestSync) {
  TraceText text(0x080);
  EXPECT_EQ(text.describe(line("(5.000000) can0 100#")).after_sync, std::nullopt);
  const auto sync = text.describe(line("(5.001000) sync 080#"));
  EXPECT_EQ(trace_line(sync), "         5.001000         0  SYNC         -  edge");
  EXPECT_EQ(text.describe(line("(5.001301) can0 100#")).after_sync, std::chrono::microseconds(301));
  (void)text.describe(line("(5.002000) sync 080#"));
  EXPECT_EQ(text.describe(line("(5.002299) can0 100#")).after_sync, std::chrono::microseconds(299));
}

TEST(TraceText, NamesErrorsAndWhatIsNoTelegram) {
  TraceText text;
  EXPECT_EQ(text.describe(line("(1.000000) can0 20000008#0000000000000000")).words,
            "error frame: protocol violation");
  EXPECT_EQ(text.describe(line("(1.000000) can0 20000044#0000000000000000")).words,
            "error frame: controller problem, bus-off");
  const auto wrong = text.describe(line("(1.000000) can0 503#71"));
  EXPECT_EQ(wrong.channel, "CC");
  EXPECT_EQ(wrong.words, "no CANsync telegram (wrong length): 0x503 [1] 71");
  EXPECT_EQ(text.describe(line("(1.000000) can0 523#712D0000")).words,
            "no CANsync telegram (wrong slave number): 0x523 [4] 71 2D 00 00");
  EXPECT_EQ(text.describe(line("(1.000000) can0 00000503#712D0000")).words,
            "no CANsync telegram (extended frame): 0x00000503 [4] 71 2D 00 00");
  EXPECT_EQ(text.describe(line("(1.000000) can0 00000503#R")).words,
            "no CANsync telegram (remote frame): 0x00000503 [0]");
  EXPECT_EQ(text.describe(line("(1.000000) can0 00000123#")).channel, "-");
}

/// A log in a file of its own.
class TraceVerb : public testing::Test {
 protected:
  void write(const std::string& content) { std::ofstream(path_, std::ios::binary) << content; }
  ~TraceVerb() override { std::remove(path_.c_str()); }

  struct Outcome {
    ExitCode code;
    std::string data;
    std::string remarks;
  };
  Outcome trace(const std::vector<std::string>& options) {
    using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;
    const File data(std::tmpfile(), &std::fclose);
    const File remarks(std::tmpfile(), &std::fclose);
    std::vector<const char*> arguments{"cansync", "trace", path_.c_str()};
    for (const std::string& option : options) arguments.push_back(option.c_str());
    const ExitCode code =
        run(static_cast<int>(arguments.size()), arguments.data(), data.get(), remarks.get());
    return {code, read_back(data.get()), read_back(remarks.get())};
  }

  std::string path_ = testing::TempDir() + "cansync_trace_" +
                      testing::UnitTest::GetInstance()->current_test_info()->name() + ".log";

 private:
  static std::string read_back(std::FILE* file) {
    std::string text;
    std::rewind(file);
    for (int c = std::fgetc(file); c != EOF; c = std::fgetc(file)) text += static_cast<char>(c);
    return text;
  }
};

const char* const kLog =
    "(1.000000) sync 080#\n"
    "(1.000300) can0 101#0100020003000400\n"
    "(1.000450) can0 301#0100020003000400\n"
    "(1.000900) can0 502#712D0000\n"
    "(1.001000) sync 080#\n"
    "(1.001040) can0 582#012D01800000\n";

TEST_F(TraceVerb, AnotherFormatIsNamedWithTheRemedy) {
  write(
      "date Mon Nov 2 10:00:00 2026\nbase hex  timestamps absolute\n 0.100 1 123 Rx d 8 00 01 02 03 04 05 06 07\n");
  const Outcome outcome = trace({});
  EXPECT_EQ(outcome.code, ExitCode::failed);
  EXPECT_EQ(outcome.data, "");
  EXPECT_NE(outcome.remarks.find("it looks like a Vector ASC log; convert it: asc2log"), std::string::npos)
      << outcome.remarks;
}

TEST_F(TraceVerb, AFileThatIsReadInPartHasAnExitStatusOfItsOwn) {
  write(std::string(kLog) + "nonsense\n");
  EXPECT_EQ(trace({}).code, ExitCode::in_part);
  write("nonsense\n");
  EXPECT_EQ(trace({}).code, ExitCode::failed);
}

TEST_F(TraceVerb, OneSlaveAlone) {
  write(kLog);
  const Outcome outcome = trace({"--slave", "2"});
  EXPECT_EQ(outcome.code, ExitCode::done) << outcome.remarks;
  EXPECT_EQ(outcome.data,
            "           TIME s   SYNC+us  CHANNEL  SLAVE  WHAT\n"
            "         1.000000         0  SYNC         -  edge\n"
            "         1.000900       900  CC           2  read parameter 301\n"
            "         1.001000         0  SYNC         -  edge\n"
            "         1.001040        40  RC           2  parameter 301 = 32769 (0x8001, word)\n");
}

TEST_F(TraceVerb, CandumpInAndOutIsTheSame) {
  std::string log = kLog;
  write(log);
  const Outcome outcome = trace({"--candump"});
  EXPECT_EQ(outcome.code, ExitCode::done);
  std::ofstream(path_, std::ios::binary) << outcome.data;
  EXPECT_EQ(trace({"--candump"}).data, outcome.data) << "what was written is read again";
  EXPECT_NE(outcome.data.find(" can0 502#712D0000\n"), std::string::npos);
  EXPECT_EQ(trace({"--candump", "--count", "2"}).data,
            outcome.data.substr(0, outcome.data.find('\n', outcome.data.find('\n') + 1) + 1));
}

TEST_F(TraceVerb, GarbageIsNamedCountedAndPassedOver) {
  std::string garbage;
  for (int i = 0; i < 256; ++i) garbage += static_cast<char>(i == '\n' ? ' ' : i);
  write(std::string("(1.000000) sync 080#\r\n\n# 3 lines lost\nnonsense\n") + garbage + "\n" +
        std::string(100000, '(') + "\n(1.000300) can0 101#01\n(1.000000) can0 101#0100\n(1.2) can0");
  const Outcome outcome = trace({});
  EXPECT_EQ(outcome.code, ExitCode::in_part);
  EXPECT_NE(outcome.remarks.find(":3: # 3 lines lost"), std::string::npos) << outcome.remarks;
  EXPECT_NE(outcome.remarks.find(":4:1: "), std::string::npos) << outcome.remarks;
  EXPECT_NE(outcome.remarks.find(":5:"), std::string::npos) << outcome.remarks;
  EXPECT_NE(outcome.remarks.find(":6: over 8192 characters"), std::string::npos) << outcome.remarks;
  EXPECT_NE(outcome.remarks.find(":9:"), std::string::npos) << "also the last line without an end";
  EXPECT_NE(outcome.remarks.find("4 lines were not understood"), std::string::npos) << outcome.remarks;
  EXPECT_NE(outcome.data.find("edge"), std::string::npos);
  EXPECT_NE(outcome.data.find("word 0x0001"), std::string::npos);
}

TEST_F(TraceVerb, AMarkOfUtf8AndWhatCandumpSaysOfAnErrorFrameAreNoDamage) {
  write(
      "\xEF\xBB\xBF  can0  20000004   [8]  00 0C 00 00 00 00 00 00   ERRORFRAME\n"
      "\tcontroller-problem{rx-error-warning,tx-error-warning}\n  can0  101   [2]  01 00\n");
  const Outcome outcome = trace({});
  EXPECT_EQ(outcome.code, ExitCode::done) << outcome.remarks;
  EXPECT_NE(outcome.data.find("controller problem"), std::string::npos) << outcome.data;
  EXPECT_NE(outcome.data.find("word 0x0001"), std::string::npos) << outcome.data;
}

TEST_F(TraceVerb, ManyProblemsAreOnlyCounted) {
  std::string log;
  for (int i = 0; i < 1000; ++i) log += "nonsense\n";
  write(log);
  const Outcome outcome = trace({});
  EXPECT_NE(outcome.remarks.find("1000 lines were not understood"), std::string::npos);
  EXPECT_EQ(outcome.remarks.find(":11:"), std::string::npos);
}

TEST_F(TraceVerb, AnotherSyncIdentifierAndJson) {
  write("(1.000000) can0 081#\n(1.000300) can0 101#0100\n");
  EXPECT_EQ(
      trace({"--sync", "0x81", "--json"}).data,
      "{\"time_us\":1000000,\"after_sync_us\":0,\"interface\":\"can0\",\"identifier\":129,\"channel\":\"SYNC\",\"slave\":null,\"data\":[],\"text\":\"edge\"}\n"
      "{\"time_us\":1000300,\"after_sync_us\":300,\"interface\":\"can0\",\"identifier\":257,\"channel\":\"WRC1\",\"slave\":1,\"data\":[1,0],\"text\":\"reference "
      "values, asks slave 1: word 0x0001\"}\n");
}

TEST_F(TraceVerb, WhatCannotBeReadIsSaid) {
  const Outcome missing = trace({});
  EXPECT_EQ(missing.code, ExitCode::failed);
  EXPECT_NE(missing.remarks.find(path_), std::string::npos);
  path_ = testing::TempDir();  // a folder
  const Outcome folder = trace({});
  EXPECT_EQ(folder.code, ExitCode::failed);
  EXPECT_NE(folder.remarks.find(path_ + ": Is a directory"), std::string::npos) << folder.remarks;
  path_ = "nocan99";  // neither a file nor an interface
  const Outcome nothing = trace({});
  EXPECT_EQ(nothing.code, ExitCode::failed);
  EXPECT_NE(nothing.remarks.find("nocan99: there is no such file here, and no such interface"),
            std::string::npos);
  EXPECT_NE(nothing.remarks.find('`'), std::string::npos) << "the remedy: " << nothing.remarks;
}

}  // namespace
}  // namespace cansync::cli
