#include <gtest/gtest.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "can/candump.h"
#include "can/frame_length.h"
#include "scripted_node.h"
#include "sim/line.h"
#include "sim/trace_file.h"
#include "sim/trace_ring.h"

namespace {

using namespace sim::test;
using Nodes = std::vector<std::unique_ptr<sim::Node>>;

// A file that is gone after the test.
class TraceFileTest : public testing::Test {
 protected:
  TraceFileTest()
      : path_(std::filesystem::temp_directory_path() /
              ("cansync_trace_" + std::to_string(::getpid()) + "_" +
               testing::UnitTest::GetInstance()->current_test_info()->name() + ".log")) {}
  ~TraceFileTest() override { std::filesystem::remove(path_); }

  std::vector<std::string> lines() const {
    std::ifstream file(path_);
    std::vector<std::string> all;
    for (std::string line; std::getline(file, line);) all.push_back(line);
    return all;
  }

  std::filesystem::path path_;
};

TEST_F(TraceFileTest, WritesStartsOfFramesAndSyncEdges) {
  sim::TraceFile trace({.path = path_, .bus = "line1"});
  Nodes nodes;
  auto node = std::make_unique<ScriptedNode>(1);
  node->expect("101#0102030405060708").reply("301#AA", us(20));
  nodes.push_back(std::move(node));
  sim::Line line({.trace = &trace}, std::move(nodes));
  run_until(line, us(1000));
  line.sync_edge(us(1000));
  run_until(line, us(1300.5));
  line.send(frame("101#0102030405060708"));
  run_until(line, us(2000));
  const auto summary = trace.close();
  const unsigned answer = 1'001'300 + can::frame_bits(frame("101#0102030405060708")) - 3 + 20;
  EXPECT_EQ(lines(), (std::vector<std::string>{
                         "(0000000001.001000) sync 080#", "(0000000001.001300) line1 101#0102030405060708",
                         "(0000000001." + std::to_string(answer).substr(1) + ") line1 301#AA"}));
  EXPECT_EQ(summary.lines, 3u);
  EXPECT_EQ(summary.lost, 0u);
  EXPECT_EQ(summary.error, 0);
}

TEST_F(TraceFileTest, ErrorFramesStandAtTheirErrorFlag) {
  sim::TraceFile trace({.path = path_, .offset = {}});
  sim::Line line({.faults = {{.kind = sim::FaultKind::corrupted, .count = 1}}, .trace = &trace}, {});
  line.send(frame("101#"));
  run_until(line, us(1000));
  trace.close();
  const auto written = lines();
  ASSERT_EQ(written.size(), 2u);
  EXPECT_EQ(written[0].substr(20), "sim 20000008#0000000000000000");
  EXPECT_EQ(written[1].substr(20), "sim 101#");
}

TEST_F(TraceFileTest, EveryLineOfABusyBusCanBeParsedAndIsInOrder) {
  sim::TraceFile trace({.path = path_, .bus = "can0"});
  sim::Line line({.faults = {{.kind = sim::FaultKind::corrupted, .probability = 0.05}}, .trace = &trace}, {});
  for (int interval = 0; interval < 300; ++interval) {
    line.sync_edge(us(1000 * interval));
    for (const char* what : {"101#0011223344556677", "181#FF", "505#70FF0000"}) line.send(frame(what));
    run_until(line, us(1000 * interval + 1000));
  }
  const auto summary = trace.close();
  const auto written = lines();
  EXPECT_EQ(summary.lines, written.size());
  std::size_t frames = 0;
  std::size_t errors = 0;
  std::chrono::microseconds last{0};
  for (const std::string& text : written) {
    const auto parsed = can::parse_candump_line(text);
    ASSERT_TRUE(std::holds_alternative<can::CandumpLine>(parsed)) << text;
    const auto& one = std::get<can::CandumpLine>(parsed);
    EXPECT_GE(one.time, last) << text;
    last = one.time;
    if (one.interface == "can0") (one.frame.error ? errors : frames) += 1;
  }
  EXPECT_EQ(frames, line.counters().frames);
  EXPECT_EQ(errors, line.counters().error_frames);
  EXPECT_EQ(written.size() - frames - errors, 300u);
  EXPECT_GT(errors, 20u);
}

TEST_F(TraceFileTest, BackgroundLosesNothingThatFits) {
  sim::TraceFile trace({.path = path_, .background = true, .ring_lines = 20'000});
  sim::TracedFrame traced;
  traced.frame = frame("101#00");
  for (int n = 0; n < 20'000; ++n) {
    traced.start = us(n);
    traced.frame.data[0] = static_cast<std::uint8_t>(n);
    trace.frame(traced);
  }
  const auto summary = trace.close();
  EXPECT_EQ(summary.lines, 20'000u);
  EXPECT_EQ(summary.lost, 0u);
  const auto written = lines();
  ASSERT_EQ(written.size(), 20'000u);
  EXPECT_EQ(written[19'999], "(0000000001.019999) sim 101#1F");
}

TEST_F(TraceFileTest, BackgroundCountsWhatFindsNoRoomAndSaysSo) {
  sim::TraceFile trace({.path = path_, .background = true, .ring_lines = 1});
  constexpr std::uint64_t kLines = 200'000;  // far faster than any file takes them one by one
  for (std::uint64_t n = 0; n < kLines; ++n) trace.sync(us(static_cast<double>(n)));
  const auto summary = trace.close();
  EXPECT_GT(summary.lost, 0u);
  EXPECT_EQ(summary.lines + summary.lost, kLines);
  const auto written = lines();
  ASSERT_EQ(written.size(), summary.lines + 1);
  EXPECT_EQ(written.back(), "# " + std::to_string(summary.lost) + " lines lost");
}

TEST_F(TraceFileTest, CloseTwiceGivesTheSameSummary) {
  sim::TraceFile trace({.path = path_});
  trace.sync(us(1));
  EXPECT_EQ(trace.close().lines, 1u);
  EXPECT_EQ(trace.close().lines, 1u);
}

TEST_F(TraceFileTest, FullDiskIsReported) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full";
  sim::TraceFile trace({.path = "/dev/full"});
  trace.sync(us(1));
  EXPECT_EQ(trace.close().error, ENOSPC);
}

TEST_F(TraceFileTest, FileThatCannotBeOpened) {
  try {
    const sim::TraceFile trace({.path = "/nonexistent/folder/trace.log"});
    FAIL() << "opened";
  } catch (const std::system_error& error) {
    EXPECT_EQ(error.code().value(), ENOENT);
    EXPECT_NE(std::string(error.what()).find("/nonexistent/folder/trace.log"), std::string::npos);
  }
  EXPECT_THROW(sim::TraceFile({.path = path_, .ring_lines = 0}), std::invalid_argument);
}

TEST(TraceInterface, FitsWhatReadersTake) {
  EXPECT_EQ(sim::trace_interface("line1"), "line1");
  EXPECT_EQ(sim::trace_interface("press line 2"), "press_line_2");
  EXPECT_EQ(sim::trace_interface("a-name-of-more-than-15"), "a-name-of-more-");
  EXPECT_EQ(sim::trace_interface("sync"), "sync_");
  EXPECT_EQ(sim::trace_interface(""), "_");
  EXPECT_TRUE(can::is_interface_name(sim::trace_interface("\xC3\xA4\n\t ")));
}

TEST(TraceRing, KeepsOrderBetweenTwoThreads) {
  sim::TraceRing<int> ring(64);
  constexpr int kValues = 50'000;
  std::thread writer([&ring] {
    for (int n = 0; n < kValues;) {
      if (ring.push(n)) ++n;
    }
  });
  int wrong = 0;
  for (int expected = 0; expected < kValues;) {
    int value = -1;
    if (!ring.pop(value)) continue;
    if (value != expected) ++wrong;
    ++expected;
  }
  writer.join();
  EXPECT_EQ(wrong, 0);
}

TEST(TraceRing, HasRoomForItsCapacity) {
  sim::TraceRing<int> ring(3);
  int value = 0;
  EXPECT_FALSE(ring.pop(value));
  for (int round = 0; round < 5; ++round) {
    for (int n = 0; n < 3; ++n) EXPECT_TRUE(ring.push(n));
    EXPECT_FALSE(ring.push(3));
    for (int n = 0; n < 3; ++n) {
      ASSERT_TRUE(ring.pop(value));
      EXPECT_EQ(value, n);
    }
  }
}

}  // namespace
