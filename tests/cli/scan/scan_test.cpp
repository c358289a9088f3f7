// `scan` of a recording: points, slaves, foreign identifiers, as text and as objects; what it refuses.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <sstream>

#include "cli/app/application.h"

namespace cansync::cli {
namespace {

namespace fs = std::filesystem;

std::string content_of(const fs::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Two intervals at 500 kbit/s and more: WRC1 asks slave 3, which answers; a frame of somebody else.
std::string small_log() {
  std::string log;
  for (int i = 0; i < 50; ++i) {
    const int us = 2000 * i;
    const auto line = [&](int after, const char* frame) {
      char text[96];
      std::snprintf(text, sizeof text, "(1.%06d) can7 %s\n", us + after, frame);
      log += text;
    };
    line(0, "080#");
    line(700, "103#0000000000000000");
    line(900, "303#0100020003000400");
    line(1800, "503#712D0000");
    line(1900, "18FF1234#01");
  }
  return log;
}

class ScanVerb : public ::testing::Test {
 protected:
  ScanVerb() {
    std::string name = (fs::temp_directory_path() / "cansync_scan.XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
    log_ = (folder_ / "line.log").string();
    std::ofstream(log_) << small_log();
  }
  ~ScanVerb() override { fs::remove_all(folder_); }

  ExitCode run_scan(std::vector<std::string> words) {
    words.insert(words.begin(), {"cansync", "scan"});
    std::vector<const char*> arguments;
    for (const std::string& word : words) arguments.push_back(word.c_str());
    ExitCode code{};
    {
      using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;
      const File out(std::fopen((folder_ / "data").c_str(), "w"), &std::fclose);
      const File told(std::fopen((folder_ / "remarks").c_str(), "w"), &std::fclose);
      code = run(static_cast<int>(arguments.size()), arguments.data(), out.get(), told.get());
    }
    data_ = content_of(folder_ / "data");
    remarks_ = content_of(folder_ / "remarks");
    return code;
  }
  bool says(const std::string& text) const { return data_.find(text) != std::string::npos; }

  fs::path folder_;
  std::string log_;
  std::string data_;
  std::string remarks_;
};

TEST_F(ScanVerb, TellsWhatIsOnALine) {
  EXPECT_EQ(run_scan({log_}), ExitCode::done) << remarks_;
  EXPECT_TRUE(says("500000 bit/s ") && says("told by the interval")) << data_;
  EXPECT_TRUE(says("2.000 ms")) << data_;
  EXPECT_TRUE(says("WRC1 50 x 8")) << data_;
  EXPECT_TRUE(says("0x18FF1234      50      1")) << data_;
}

TEST_F(ScanVerb, TellsTheSameAsObjects) {
  EXPECT_EQ(run_scan({log_, "--json"}), ExitCode::done) << remarks_;
  EXPECT_TRUE(says(R"("point":"master","found":"yes")")) << data_;
  EXPECT_TRUE(
      says(R"({"kind":"slave","slave":3,"asked":50,"answers":0,"answer_lengths":[],"polled_1":50,)"
           R"("actual_1":50,"actual_1_lengths":[8],"polled_2":0,"actual_2":0,"actual_2_lengths":[]})"))
      << data_;
  EXPECT_TRUE(says(R"({"kind":"foreign","identifier":419369524,"extended":true,"remote":false,"count":50,)"
                   R"("lengths":[1]})"))
      << data_;
}

TEST_F(ScanVerb, OfALogThatHasEachFrameTwiceTellsWhatTheLineHas) {
  ASSERT_EQ(run_scan({log_}), ExitCode::done);
  const std::string once = data_;
  std::istringstream lines(small_log());
  std::ofstream twice(log_);
  for (std::string line; std::getline(lines, line);) twice << line << '\n' << line << '\n';
  twice.close();
  EXPECT_EQ(run_scan({log_}), ExitCode::done);
  EXPECT_EQ(data_, once);
  EXPECT_NE(remarks_.find("each frame stands there twice"), std::string::npos) << remarks_;
}

TEST_F(ScanVerb, SaysThatTheTypedRateIsAnother) {
  EXPECT_EQ(run_scan({log_, "--bit-rate", "125000"}), ExitCode::done);
  EXPECT_TRUE(says("--bit-rate; its interval belongs to 500000 bit/s")) << data_;
}

TEST_F(ScanVerb, OfOtherProtocolsNothingIsDerivedOrWritten) {
  std::string log;
  for (int i = 0; i < 200; ++i) {
    char text[200];
    std::snprintf(
        text, sizeof text,
        "(1.%06d) can0 080#\n(1.%06d) can0 181#0102030405060708\n(1.%06d) can0 381#0102030405060708\n"
        "(1.%06d) can0 705#05\n",
        4000 * i, 4000 * i + 300, 4000 * i + 900, 4000 * i + 1500);
    log += text;
  }
  const std::string path = (folder_ / "canopen.log").string();
  std::ofstream(path) << log;
  const std::string out = (folder_ / "out").string();
  EXPECT_EQ(run_scan({path, "--write", out}), ExitCode::not_cansync);
  EXPECT_NE(remarks_.find("this does not look like CANsync; it looks like CANopen: 200 heartbeats"),
            std::string::npos)
      << remarks_;
  EXPECT_TRUE(says("CANopen")) << data_;
  EXPECT_FALSE(says("RDC1")) << data_;
  EXPECT_FALSE(says("4.000 ms")) << data_;
  EXPECT_FALSE(fs::exists(out));
}

TEST_F(ScanVerb, ALineThatIsNoFrameIsReadInPart) {
  std::ofstream(log_, std::ios::app) << "nonsense\n";
  EXPECT_EQ(run_scan({log_}), ExitCode::in_part);
  EXPECT_TRUE(says("WRC1 50 x 8")) << data_;
}

TEST_F(ScanVerb, OthersAreCountedInWordsThatFit) {
  const auto others = [&](unsigned identifiers) {
    std::ofstream log(log_);
    log << "# a remark\n";
    for (unsigned i = 0; i < identifiers; ++i) {
      char line[80];
      std::snprintf(line, sizeof line, "(1.%06u) can0 %03X#00\n", i, 0x600 + i);
      log << line;
    }
    log.close();
    (void)run_scan({log_});
    return data_;
  };
  EXPECT_NE(others(1).find(" 1 identifier "), std::string::npos) << data_;
  EXPECT_NE(others(17).find(" 17 identifiers "), std::string::npos) << data_;
  EXPECT_NE(others(70).find(" over 64 identifiers "), std::string::npos) << data_;
  EXPECT_EQ(others(0).find("every frame is one"), std::string::npos) << data_;
}

TEST_F(ScanVerb, AnInterfaceThatIsNotInTheLogIsNamedWithOneThatIs) {
  EXPECT_EQ(run_scan({log_, "--from", "can3"}), ExitCode::usage);
  EXPECT_NE(remarks_.find("--from: found 'can3'"), std::string::npos) << remarks_;
  EXPECT_NE(remarks_.find("such as can7"), std::string::npos) << remarks_;
}

TEST_F(ScanVerb, AsksNoRecordingAndNothingWithoutAsk) {
  EXPECT_EQ(run_scan({log_, "--ask", "--yes"}), ExitCode::usage);
  EXPECT_NE(remarks_.find("--ask: found a recording"), std::string::npos) << remarks_;
  EXPECT_EQ(run_scan({log_, "--parameters"}), ExitCode::usage);
  EXPECT_EQ(run_scan({(folder_ / "none.log").string()}), ExitCode::failed);
  EXPECT_EQ(run_scan({log_, "--bit-rate", "300000"}), ExitCode::usage);
}

}  // namespace
}  // namespace cansync::cli
