// The four bit rates one after the other: what `ip` is told, what is chosen, and that the interface is set
// back.
#include "cli/scan/rate_trials.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

namespace cansync::cli {
namespace {

/// Stands in for `ip` and an interface on a line of one bit rate.
class RateTrialsTest : public ::testing::Test {
 protected:
  RateTools tools() {
    return {[this](const std::vector<std::string>& words) { return ip(words); },
            [this] {
              observe::Census census;
              census.frames = set_ == line_ ? 500 : 40;
              census.error_frames = set_ == line_ ? 1 : 40;
              return census;
            },
            [this] { return stop_; },
            [this](const std::vector<std::vector<std::string>>& commands) {
              guarded_ = commands;
              return std::shared_ptr<void>(&guarded_, [this](void*) { called_off_ = true; });
            }};
  }

  ChildResult ip(const std::vector<std::string>& words) {
    std::string typed;
    for (const std::string& word : words) typed += (typed.empty() ? "" : " ") + word;
    typed_.push_back(typed);
    ChildResult result;
    if (words[0] == "-details") result.output = (listens_ ? "can <LISTEN-ONLY> state" : "can state") + shown_;
    if (typed.find("bitrate") != std::string::npos) {
      set_ = words[6];
      if (!supported_) result = {"", "RTNETLINK answers: Operation not supported", 2};
    }
    return result;
  }

  can::LinkFacts facts(std::uint32_t rate, bool up) const {
    can::LinkFacts link;
    link.present = true;
    link.up = up;
    if (rate != 0) link.timing = can::LinkTiming{rate, 600};
    return link;
  }

  std::string line_ = "250000";
  std::string set_;
  bool listens_ = false;
  bool supported_ = true;
  bool stop_ = false;
  std::string shown_;
  std::vector<std::vector<std::string>> guarded_;
  bool called_off_ = false;
  std::vector<std::string> typed_;
};

TEST_F(RateTrialsTest, FindsTheRateAndSetsTheInterfaceBack) {
  const auto trials = try_rates("can3", facts(1'000'000, true), tools());
  ASSERT_EQ(trials.size(), 4u);
  const RateTrial* heard = heard_trial(trials);
  ASSERT_NE(heard, nullptr);
  EXPECT_EQ(heard->bit_rate, BitRate::kbit250);
  const std::vector<std::string> last(typed_.end() - 4, typed_.end());
  EXPECT_EQ(last, (std::vector<std::string>{
                      "link set can3 down", "link set can3 type can bitrate 1000000 listen-only off",
                      "link set can3 type can bitrate 1000000 listen-only off sample-point 0.600",
                      "link set can3 up"}));
  // Until then never anything but listening.
  for (auto line = typed_.begin(); line != typed_.end() - 4; ++line)
    EXPECT_EQ(line->find("listen-only off"), std::string::npos) << *line;
}

TEST_F(RateTrialsTest, SetsTheSegmentsOfABitBackAlsoWhenItIsKilled) {
  shown_ =
      " ERROR-ACTIVE restart-ms 0\n  bitrate 500000 sample-point 0.600\n"
      "  tq 200 prop-seg 2 phase-seg1 3 phase-seg2 4 sjw 2 brp 5\n"
      "  mcp251x: tseg1 3..16 tseg2 2..8 sjw 1..4 brp 1..64 brp_inc 1\n  clock 8000000";
  try_rates("can3", facts(500'000, true), tools());
  EXPECT_EQ(typed_[typed_.size() - 2],
            "link set can3 type can tq 200 prop-seg 2 phase-seg1 3 phase-seg2 4 sjw 2");
  ASSERT_EQ(guarded_.size(), 5u);
  for (std::size_t i = 0; i < guarded_.size(); ++i) {
    std::string words;
    for (const std::string& word : guarded_[i]) words += (words.empty() ? "" : " ") + word;
    EXPECT_EQ(words, typed_[typed_.size() - 5 + i]);
  }
  EXPECT_TRUE(called_off_) << "after the interface is back";
}

TEST_F(RateTrialsTest, LeavesAnInterfaceThatWasDownDown) {
  listens_ = true;
  try_rates("can3", facts(0, false), tools());
  EXPECT_EQ(typed_.back(), "link set can3 down");
}

TEST_F(RateTrialsTest, TriesNothingWithADriverThatCannotOnlyListen) {
  supported_ = false;
  EXPECT_THROW(try_rates("can3", facts(500'000, true), tools()), std::runtime_error);
  EXPECT_EQ(typed_.back(), "link set can3 up") << "as it was";
  EXPECT_EQ(std::count(typed_.begin(), typed_.end(), "link set can3 up"), 1);
}

TEST_F(RateTrialsTest, ASilentLineTellsNothing) {
  line_ = "none of them";
  EXPECT_EQ(heard_trial(try_rates("can3", facts(0, false), tools())), nullptr);
  stop_ = true;
  EXPECT_TRUE(try_rates("can3", facts(0, false), tools()).empty());
}

}  // namespace
}  // namespace cansync::cli
