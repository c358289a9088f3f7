// `can dump FILE` and `messages FILE`: recordings without a daemon, in the forms that live frames have.
#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <variant>
#include <vector>

#include "cli/app/application.h"
#include "cli/trace/trace_source.h"
#include "system/descriptor.h"

namespace cansync::cli {
namespace {

std::string read_back(std::FILE* file) {
  std::string text;
  std::rewind(file);
  for (int c = std::fgetc(file); c != EOF; c = std::fgetc(file)) text += static_cast<char>(c);
  return text;
}

/// A recording, and a file of signals, each in a file of its own.
class RecordingVerb : public testing::Test {
 protected:
  RecordingVerb() {
    setenv("TZ", "UTC", 1);
    tzset();
  }
  ~RecordingVerb() override {
    for (const std::string& path : {log_, dbc_, capture_}) std::remove(path.c_str());
  }
  struct Outcome {
    ExitCode code;
    std::string data;
    std::string remarks;
  };
  static Outcome call(const std::vector<std::string>& words) {
    using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;
    const File data(std::tmpfile(), &std::fclose);
    const File remarks(std::tmpfile(), &std::fclose);
    std::vector<const char*> arguments{"cansync"};
    for (const std::string& word : words) arguments.push_back(word.c_str());
    const ExitCode code =
        run(static_cast<int>(arguments.size()), arguments.data(), data.get(), remarks.get());
    return {code, read_back(data.get()), read_back(remarks.get())};
  }
  void record(const std::string& content) const { std::ofstream(log_, std::ios::binary) << content; }
  Outcome dump(std::vector<std::string> options = {}) const {
    options.insert(options.begin(), {"can", "dump", log_});
    return call(options);
  }
  Outcome messages(std::vector<std::string> options = {}) const {
    options.insert(options.begin(), {"j1939", "messages", log_});
    return call(options);
  }

  std::string log_ = path(".log");
  std::string dbc_ = path(".dbc");
  std::string capture_ = path(".pcapng");

 private:
  static std::string path(const char* end) {
    return testing::TempDir() + "cansync_recording_" +
           testing::UnitTest::GetInstance()->current_test_info()->name() + end;
  }
};

constexpr const char* kLog =
    "(1700000000.000100) can0 123#E803\n"
    "(1700000000.250000) can0 18DAF110#R4\n"
    "(1700000001.000000) can0 124#FF\n";

TEST_F(RecordingVerb, FramesHaveTheColumnsOfTheDaemon) {
  record(kLog);
  const Outcome outcome = dump();
  EXPECT_EQ(outcome.code, ExitCode::done) << outcome.remarks;
  EXPECT_EQ(outcome.remarks, "");
  EXPECT_EQ(outcome.data,
            "TIME                           ID  LEN  RANGE  DATA                     MEANING\n"
            "2023-11-14 22:13:20.000       123    2      -  E8 03\n"
            "2023-11-14 22:13:20.250  18DAF110    4      -  remote\n"
            "2023-11-14 22:13:21.000       124    1      -  FF\n");
}

TEST_F(RecordingVerb, FiltersAndSignalsAreThoseOfTheDaemonsFrames) {
  record(kLog);
  std::ofstream(dbc_) << "VERSION \"\"\nBU_: A\nBO_ 291 Motor: 2 A\n"
                         " SG_ Speed : 0|16@1+ (0.5,0) [0|0] \"rpm\" A\n";
  const Outcome one = dump({"--dbc", dbc_, "--id", "100-123", "--kind", "data"});
  EXPECT_EQ(one.code, ExitCode::done) << one.remarks;
  EXPECT_NE(one.data.find("Motor: Speed 500 rpm\n"), std::string::npos) << one.data;
  EXPECT_EQ(one.data.find("124"), std::string::npos) << one.data;
  EXPECT_EQ(
      dump({"--json", "--count", "1", "--dbc", dbc_}).data,
      "{\"time_ns\":1700000000000100000,\"interface\":\"can0\",\"identifier\":291,\"extended\":false,"
      "\"remote\":false,\"length\":2,\"data\":[232,3],\"range\":null,\"high_priority\":null,"
      "\"message\":\"Motor\",\"signals\":[{\"name\":\"Speed\",\"raw\":1000,\"value\":500,\"unit\":\"rpm\","
      "\"word\":\"\"}]}\n");
}

TEST_F(RecordingVerb, WhatIsWrittenAsALogOrACaptureIsReadTheSame) {
  record(kLog);
  EXPECT_EQ(dump({"--candump"}).data, kLog);
  EXPECT_EQ(dump({"--write", capture_}).code, ExitCode::done);
  const Outcome again = call({"can", "dump", capture_, "--candump"});
  EXPECT_EQ(again.code, ExitCode::done) << again.remarks;
  EXPECT_EQ(again.data, kLog);
}

/// Ten frames of one node, the same each time; each again after `again`.
std::string twice_log(std::chrono::microseconds again) {
  std::string log;
  for (int i = 0; i < 10; ++i)
    for (const int after : {0, static_cast<int>(again.count())})
      log += fmt::format("(1.{:06d}) can0 123#E803\n", 1000 * i + after);
  return log;
}

TEST_F(RecordingVerb, OfALogThatHasEachFrameTwiceEachIsTakenOnce) {
  record(twice_log(std::chrono::microseconds(4)));
  const Outcome outcome = dump({"--candump"});
  EXPECT_EQ(outcome.code, ExitCode::done) << "nothing was left out of what was on the bus";
  EXPECT_EQ(std::count(outcome.data.begin(), outcome.data.end(), '\n'), 10) << outcome.data;
  EXPECT_NE(outcome.remarks.find("each frame stands there twice"), std::string::npos) << outcome.remarks;
  // 2 bytes with an identifier of 11 bits have 63 bits and more: what follows later can be a second frame.
  record(twice_log(std::chrono::microseconds(90)));
  const Outcome sent_twice = dump({"--candump"});
  EXPECT_EQ(std::count(sent_twice.data.begin(), sent_twice.data.end(), '\n'), 20);
  EXPECT_EQ(sent_twice.remarks, "");
}

TEST_F(RecordingVerb, WhatComesThroughAPipeIsGivenAsItComes) {
  ASSERT_EQ(::mkfifo(log_.c_str(), 0600), 0);
  const sys::Descriptor pipe(::open(log_.c_str(), O_RDWR | O_CLOEXEC));
  ASSERT_TRUE(pipe.is_open());
  const auto source = open_log(log_);
  const auto next = [&source] {
    TraceItem item = source->next();
    for (int i = 0; i < 200 && std::holds_alternative<TraceNothing>(item); ++i) item = source->next();
    return item;
  };
  // Far fewer than are looked at in a file before the first is given.
  std::istringstream log(twice_log(std::chrono::microseconds(90)));
  for (std::string line; std::getline(log, line);) {
    line += '\n';
    ASSERT_EQ(::write(pipe.number(), line.data(), line.size()), static_cast<ssize_t>(line.size()));
    ASSERT_TRUE(std::holds_alternative<can::CandumpLine>(next())) << line;
  }
}

TEST_F(RecordingVerb, StampsThatAreNoTimeOfTheBusTellNothingOfEachFrameTwice) {
  const auto is_whole = [&](const std::string& log) {
    record(log);
    const Outcome outcome = dump({"--candump"});
    EXPECT_EQ(outcome.remarks, "") << log;
    return std::count(outcome.data.begin(), outcome.data.end(), '\n') ==
           std::count(log.begin(), log.end(), '\n');
  };
  std::string differences;  // candump -td
  std::string seconds;
  std::string virtual_bus;  // faster than any
  for (int i = 0; i < 20; ++i) {
    differences += fmt::format("(000.01000{}) can0 123#E803\n", i % 3);
    seconds += fmt::format("({}.000000) can0 123#E803\n", 1700000000 + i / 2);
    virtual_bus += fmt::format("(1700000000.{:06d}) can0 123#E803\n", 7 * i);
  }
  EXPECT_TRUE(is_whole(differences));
  EXPECT_TRUE(is_whole(seconds));
  EXPECT_TRUE(is_whole(virtual_bus));
}

TEST_F(RecordingVerb, ATableOfSignalsThatIsRefusedIsToldInItsLines) {
  record(kLog);
  const std::string table = capture_ + ".toml";
  std::ofstream(table) << "[[message]]\nidentifer = 1\n";
  const Outcome outcome = call({"can", "dump", log_, "--signals", table});
  std::remove(table.c_str());
  EXPECT_EQ(outcome.code, ExitCode::usage);
  EXPECT_NE(outcome.remarks.find(".toml:2:1: "), std::string::npos) << outcome.remarks;
  EXPECT_EQ(outcome.remarks.find("\n\n"), std::string::npos) << "no empty line: " << outcome.remarks;
}

TEST_F(RecordingVerb, WhatIsLeftOutIsReportedAndHasAnExitStatusOfItsOwn) {
  std::string log = kLog;
  for (int i = 0; i < 12; ++i) log += "nonsense\n";
  record(log);
  const Outcome outcome = dump();
  EXPECT_EQ(outcome.code, ExitCode::in_part);
  EXPECT_NE(outcome.data.find(" 124 "), std::string::npos);
  EXPECT_NE(outcome.remarks.find(":4:1: "), std::string::npos) << outcome.remarks;
  EXPECT_EQ(outcome.remarks.find(":14:"), std::string::npos) << outcome.remarks;
  EXPECT_NE(outcome.remarks.find("12 lines were not understood"), std::string::npos) << outcome.remarks;
  EXPECT_NE(dump({"--json"}).remarks.find(":15:"), std::string::npos) << "a program gets all";
  EXPECT_EQ(messages().code, ExitCode::in_part);
  record("nonsense\n");
  EXPECT_EQ(dump().code, ExitCode::failed);
}

TEST_F(RecordingVerb, ErrorFramesAndSeveralInterfacesAreReported) {
  record(std::string(kLog) +
         "(1700000002.000000) can1 20000004#0000000000000000\n(1700000003.000000) can1 7FF#\n");
  const Outcome all = dump();
  EXPECT_EQ(all.code, ExitCode::done);
  EXPECT_NE(all.remarks.find("1 error frame is not shown"), std::string::npos) << all.remarks;
  EXPECT_NE(all.remarks.find("frames of 2 interfaces: can0, can1; --only-interface"), std::string::npos)
      << all.remarks;
  EXPECT_EQ(dump({"--only-interface", "can1", "--candump"}).data, "(1700000003.000000) can1 7FF#\n");
  EXPECT_NE(dump({"--only-interface", "can2"}).remarks.find("no frame of 'can2'; found: can0, can1"),
            std::string::npos);
  EXPECT_EQ(call({"can", "dump", "--only-interface", "can1"}).code, ExitCode::usage);
}

TEST_F(RecordingVerb, MessagesInPacketsAreAssembled) {
  record(
      "(1700000000.000000) can0 18ECFF21#200A0002FFECFE00\n"
      "(1700000000.050000) can0 18EBFF21#0101020304050607\n"
      "(1700000000.100000) can0 18EBFF21#0208090AFFFFFFFF\n"
      "(1700000000.200000) can0 0CEF3321#E803\n"
      "(1700000000.300000) can0 123#00\n"
      "(1700000000.400000) can0 18ECFF22#200A0002FFECFE00\n");
  std::ofstream(dbc_) << "VERSION \"\"\nBU_: A\nBO_ 2565865470 Peer: 2 A\n"
                         " SG_ Level : 0|16@1+ (1,0) [0|0] \"\" A\n";
  const Outcome outcome = messages({"--dbc", dbc_});
  EXPECT_EQ(outcome.code, ExitCode::in_part) << "a broadcast is not complete";
  EXPECT_EQ(
      outcome.data,
      "TIME                       PGN  PRIO  FROM   TO  BY          RANGE   LEN  DATA                     MEANING\n"
      "2023-11-14 22:13:20.100  0FEEC     6    33  255  broadcast       -    10  01 02 03 04 05 06 07 08 09 0A\n"
      "2023-11-14 22:13:20.200  0EF00     3    33   51  frame           -     2  E8 03                    Peer: Level 1000\n");
  EXPECT_NE(outcome.remarks.find("1 frame is not J1939"), std::string::npos) << outcome.remarks;
  EXPECT_NE(outcome.remarks.find("1 multi-packet message is incomplete"), std::string::npos)
      << outcome.remarks;
  EXPECT_EQ(
      messages({"--json", "--count", "1"}).data,
      "{\"time_ns\":1700000000100000000,\"interface\":\"can0\",\"pgn\":65260,\"priority\":6,\"source\":33,"
      "\"destination\":255,\"transport\":\"broadcast\",\"range\":null,\"data\":[1,2,3,4,5,6,7,8,9,10],"
      "\"message\":null,\"signals\":[],\"other_messages\":0}\n");
}

TEST_F(RecordingVerb, AFileThatIsNoneIsNamed) {
  const Outcome missing = dump();
  EXPECT_EQ(missing.code, ExitCode::failed);
  EXPECT_NE(missing.remarks.find(log_ + ": No such file"), std::string::npos) << missing.remarks;
  record("date Mon Nov 2 10:00:00 2026\nbase hex  timestamps absolute\n 0.100 1 123 Rx d 1 00\n");
  EXPECT_NE(messages().remarks.find("it looks like a Vector ASC log"), std::string::npos);
}

}  // namespace
}  // namespace cansync::cli
