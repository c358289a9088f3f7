// Damage by chance in logs and captures: what is undamaged is read as without damage, what is damaged is reported.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <fstream>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "can/pcapng.h"
#include "cli/trace/trace_source.h"
#include "support/damaged_files.h"

namespace cansync::cli {
namespace {

constexpr unsigned kFrames = 20;

can::Frame random_frame(std::mt19937& dice) {
  can::Frame frame;
  frame.extended = dice() % 2 != 0;
  frame.id = static_cast<std::uint32_t>(dice()) &
             (frame.extended ? can::kExtendedIdentifierMask : can::kStandardIdentifierMask);
  frame.remote = dice() % 8 == 0;
  frame.dlc = static_cast<std::uint8_t>(dice() % 9);
  for (unsigned i = 0; i < frame.dlc && !frame.remote; ++i) frame.data[i] = static_cast<std::uint8_t>(dice());
  return frame;
}

/// A log or a capture of one frame a millisecond.
class DamagedRecording : public testing::Test {
 protected:
  struct Read {
    std::map<std::int64_t, std::string> frames;  ///< by time in us, as lines of a log
    std::size_t count = 0;
    std::size_t problems = 0;
    std::string first_problem;
  };

  ~DamagedRecording() override { std::remove(path_.c_str()); }

  static std::string line_of(std::chrono::microseconds time, const can::Frame& frame) {
    std::array<char, can::kCandumpLineLimit> text{};
    return {text.data(), can::write_candump_line(time, "can0", frame, text)};
  }
  static std::chrono::microseconds time_of(unsigned number) {
    return std::chrono::seconds(1'700'000'000) + std::chrono::milliseconds(number);
  }

  Read read(const std::string& content) const {
    std::ofstream(path_, std::ios::binary) << content;
    const auto source = open_log(path_);
    Read out;
    for (;;) {
      const TraceItem item = source->next();
      if (std::holds_alternative<TraceEnd>(item)) return out;
      if (const auto* line = std::get_if<can::CandumpLine>(&item)) {
        out.frames[line->time.count()] = line_of(line->time, line->frame);
        ++out.count;
      }
      if (const auto* problem = std::get_if<TraceProblem>(&item)) {
        if (out.problems++ == 0) out.first_problem = problem->text;
      }
    }
  }

  /// All of `whole` but those of the frames first..last are in `damaged`.
  static void expect_others(const Read& whole, const Read& damaged, unsigned first, unsigned last,
                            unsigned seed) {
    for (unsigned i = 0; i < kFrames; ++i) {
      if (i >= first && i <= last) continue;
      const auto found = damaged.frames.find(time_of(i).count());
      ASSERT_NE(found, damaged.frames.end()) << "seed " << seed << ", frame " << i;
      ASSERT_EQ(found->second, whole.frames.at(time_of(i).count())) << "seed " << seed;
    }
  }

  std::string path_ =
      testing::TempDir() + "cansync_damaged_" + testing::UnitTest::GetInstance()->current_test_info()->name();
};

TEST_F(DamagedRecording, ALineOfALogCostsItselfAlone) {
  const unsigned files = test::damaged_files(300);
  unsigned reported = 0;
  for (unsigned seed = 0; seed < files; ++seed) {
    std::mt19937 dice(seed);
    std::vector<std::string> lines;
    for (unsigned i = 0; i < kFrames; ++i) lines.push_back(line_of(time_of(i), random_frame(dice)));
    const auto joined = [&lines] {
      std::string text;
      for (const std::string& line : lines) text += line;
      return text;
    };
    const Read whole = read(joined());
    ASSERT_EQ(whole.count, kFrames) << whole.first_problem;
    // Not the first one, by which the kind of file is known.
    const unsigned at = 1 + static_cast<unsigned>(dice() % (kFrames - 1));
    std::string& line = lines[at];
    line.pop_back();
    switch (dice() % 4) {
      case 0:  // cut
        line.resize(dice() % line.size());
        break;
      case 1:  // a character of another kind
        line[dice() % line.size()] = "()#. \x80R\0"[dice() % 8];
        break;
      case 2:  // doubled in itself
        line += line;
        break;
      default:  // a piece is missing
        line.erase(dice() % line.size(), 1 + dice() % 4);
    }
    line += '\n';
    const Read damaged = read(joined());
    expect_others(whole, damaged, at, at, seed);
    ASSERT_LE(damaged.count, kFrames) << "seed " << seed;
    ASSERT_LE(damaged.problems, 1u) << "seed " << seed;
    if (damaged.problems == 0) continue;
    ++reported;
    ASSERT_TRUE(damaged.first_problem.starts_with(path_ + ":" + std::to_string(at + 1) + ":"))
        << "seed " << seed << ": " << damaged.first_problem;
  }
  EXPECT_GT(reported, files / 2) << "most damage is seen";
}

TEST_F(DamagedRecording, ABlockOfACaptureCostsItselfOrIsReported) {
  const unsigned files = test::damaged_files(300);
  unsigned reported = 0;
  for (unsigned seed = 0; seed < files; ++seed) {
    std::mt19937 dice(seed);
    can::PcapngWriter writer;
    std::vector<std::string> blocks{can::PcapngWriter::begin("test")};
    for (unsigned i = 0; i < kFrames; ++i)
      blocks.push_back(writer.frame(time_of(i), "can0", random_frame(dice)));
    const auto joined = [&blocks] {
      std::string text;
      for (const std::string& block : blocks) text += block;
      return text;
    };
    const Read whole = read(joined());
    ASSERT_EQ(whole.count, kFrames) << whole.first_problem;
    // Not the first one, which describes the interface.
    const unsigned at = 1 + static_cast<unsigned>(dice() % (kFrames - 1));
    std::string& block = blocks[1 + at];
    const bool cut = dice() % 3 == 0;
    const bool framing = !cut && dice() % 2 == 0;
    std::string text;
    if (cut) {
      blocks.resize(2 + at);
      blocks.back().resize(1 + dice() % (blocks.back().size() - 1));
    } else if (framing) {  // one of the two lengths
      block[(dice() % 2 == 0 ? 4 : block.size() - 4) + dice() % 4] ^= static_cast<char>(1 + dice() % 255);
    } else {
      block[8 + dice() % (block.size() - 12)] ^= static_cast<char>(1 + dice() % 255);
    }
    const Read damaged = read(joined());
    expect_others(whole, damaged, at, cut || framing ? kFrames : at, seed);
    reported += damaged.problems == 0 ? 0 : 1;
    if (cut || framing) {
      ASSERT_GT(damaged.problems, 0u) << "seed " << seed << ": what is behind it is not read";
    }
    ASSERT_LE(damaged.count, kFrames) << "seed " << seed;
  }
  EXPECT_GT(reported, files / 2) << "most damage is seen";
}

}  // namespace
}  // namespace cansync::cli
