#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "config/problem.h"
#include "daemon/j1939/segment/j1939_segment.h"
#include "j1939/config/file.h"
#include "j1939/config/options.h"

namespace cansyncd {
namespace {

namespace fs = std::filesystem;

class J1939Configuration : public testing::Test {
 protected:
  J1939Configuration() {
    std::string name = (fs::temp_directory_path() / "cansyncd-test-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
  }
  ~J1939Configuration() override {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  J1939File load(const std::string& text) const {
    std::ofstream(folder_ / "f.toml") << text;
    return load_j1939_config((folder_ / "f.toml").string(), {});
  }
  /// The configuration of a file that is in order.
  J1939Config good(const std::string& text) const {
    const J1939File file = load(text);
    EXPECT_EQ(config::problems_text(file.problems), "");
    return file.config;
  }
  std::string problems(const std::string& text) const { return config::problems_text(load(text).problems); }

  fs::path folder_;
};

TEST_F(J1939Configuration, TheSmallestFileListens) {
  const J1939Config config = good("");
  EXPECT_FALSE(config.preferred);
  EXPECT_EQ(config.bus.bits_per_second, 250'000u);
  EXPECT_EQ(config.receive, std::vector<j1939::PgnRange>{{}});
  EXPECT_EQ(config.send.timeout, std::chrono::milliseconds(1250));
}

TEST_F(J1939Configuration, ANodeWithItsNameRangesAndGroups) {
  const J1939Config config = good(R"([address]
preferred = 0x80
arbitrary = true
first_other = 130
last_other = 140
takes_commands = false
[name]
identity = 5
manufacturer = 7
ecu_instance = 1
function_instance = 2
function = 3
vehicle_system = 4
vehicle_system_instance = 6
industry_group = 5
[transport]
window = 8
broadcast_interval_ms = 60
[listen]
between_others = true
[[receive]]
number = 3
first = 0xFEF0
last = 0xFEFF
source = 33
[[receive]]
number = 1
first = 0xF004
[[provide]]
number = 0
pgn = 0xFEEB
data = [1, 2, 3]
)");
  EXPECT_EQ(config.preferred, 0x80);
  EXPECT_EQ(config.name, (j1939::NameFields{5, 7, 1, 2, 3, 4, 6, 5, true}));
  const std::vector<j1939::PgnRange> ranges = {{0xF004, 0xF004, {}}, {0xFEF0, 0xFEFF, j1939::Address{33}}};
  EXPECT_EQ(config.receive, ranges);
  const j1939::NodeSettings node = J1939Parts::machine_settings(config, nullptr).node;
  EXPECT_EQ(node.claim.preferred, 0x80);
  EXPECT_EQ(node.claim.first_other, 130);
  EXPECT_EQ(node.claim.last_other, 140);
  EXPECT_FALSE(node.claim.takes_commands);
  EXPECT_TRUE(node.between_others);
  EXPECT_EQ(node.window, 8);
  EXPECT_EQ(node.spacing, std::chrono::milliseconds(60));
  ASSERT_EQ(node.provided.size(), 1u);
  EXPECT_EQ(node.provided[0].data.size(), 3u);
  EXPECT_EQ(node.filter.match(0xFEF1, 33), 1);
}

TEST_F(J1939Configuration, WithoutANameItLosesAgainstEveryNode) {
  const J1939Config config = good("[address]\npreferred = 0x80\n");
  EXPECT_EQ(j1939::compose(config.name), 0xFFFEFFFFFFFFFFFFu) << "bit 48 is reserved";
  EXPECT_EQ(J1939Parts::machine_settings(config, nullptr).node.claim.ask_time,
            std::chrono::milliseconds(250));
  EXPECT_NE(
      J1939Parts::check_text(config).find("NAME FFFEFFFFFFFFFFFF (a node that has the address keeps it)"),
      std::string::npos);
  const J1939Config contests = good("[address]\npreferred = 0x80\ncontest = true\n");
  EXPECT_EQ(J1939Parts::machine_settings(contests, nullptr).node.claim.ask_time,
            std::chrono::milliseconds(0));
  EXPECT_NE(J1939Parts::check_text(contests).find("(every other NAME wins)"), std::string::npos);
}

// 131 bits for 8 bytes, four such frames for 20: 524 us and 2096 us at 250 kbit/s.
TEST_F(J1939Configuration, GroupsThatTheBusCannotCarryAreRefused) {
  const auto text = [](int first_ms, int second_ms) {
    return fmt::format(
        "[[provide]]\nnumber = 2\npgn = 0xFEEB\nperiod_ms = {}\ndata = [1, 2, 3, 4, 5, 6, 7, 8]\n"
        "[[provide]]\nnumber = 5\npgn = 0xFEEC\nperiod_ms = {}\n"
        "data = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20]\n",
        first_ms, second_ms);
  };
  (void)good(text(1, 5));
  (void)good(text(0, 3));
  EXPECT_EQ(
      problems(text(1, 4)),
      (folder_ / "f.toml").string() +
          ":4:13: provide.2.period_ms: found 1 ms, but the groups with a period together take 104 % of the bus at "
          "250000 bit/s, without any other message; allowed: up to 100 %: longer periods, or fewer of them\n");
  EXPECT_NE(problems(text(0, 2)).find("provide.5.period_ms: found 2 ms"), std::string::npos);
}

TEST_F(J1939Configuration, WhatIsWrongNamesItsPlace) {
  EXPECT_NE(problems("[[provide]]\nnumber = 0\npgn = 0xEF01\n").find("f.toml:3"), std::string::npos);
  EXPECT_NE(problems("[[provide]]\nnumber = 0\npgn = 0xFEEB\nperiod_ms = 100\n").find("without data"),
            std::string::npos);
  for (const char* section : {"provide", "ecu"}) {
    for (const char* own : {"0xC700", "0xC800", "0xEB00", "0xEC00", "0xEE00"}) {
      const std::string text = fmt::format("[[{}]]\nnumber = 0\npgn = {}\n", section, own);
      EXPECT_NE(problems(text).find(fmt::format("f.toml:3:7: {}.0.pgn: found {}, which", section, own)),
                std::string::npos)
          << problems(text);
    }
  }
  EXPECT_NE(problems("[[receive]]\nnumber = 0\nfirst = 5\nlast = 4\n").find("f.toml:3"), std::string::npos);
  EXPECT_NE(problems("[address]\nfirst_other = 140\nlast_other = 130\n").find("f.toml:2"), std::string::npos);
  EXPECT_NE(problems("[address]\npreferred = 254\n").find("f.toml:2"), std::string::npos);
  EXPECT_NE(problems("[[ecu]]\nnumber = 0\ndestination = 254\n").find("f.toml:3"), std::string::npos);
  EXPECT_NE(problems("[[ecu]]\nnumber = 0\ndata = [256]\n").find("f.toml:3"), std::string::npos);
}

TEST_F(J1939Configuration, AGroupIsProvidedOnce) {
  EXPECT_NE(
      problems("[[provide]]\nnumber = 0\npgn = 0xFEEB\n[[provide]]\nnumber = 4\npgn = 0xFEEB\n")
          .find("f.toml:6:7: provide.4.pgn: found 0x0FEEB, which provide.0 has; allowed: each group once"),
      std::string::npos);
}

TEST_F(J1939Configuration, SimulatedNodesHaveNamesOfTheirOwn) {
  const J1939Config arbitrary = good(
      "[[ecu]]\nnumber = 0\narbitrary = true\n[[ecu]]\nnumber = 1\naddress = 1\narbitrary = true\n"
      "[[ecu]]\nnumber = 2\naddress = 2\nidentity = 0\n");
  EXPECT_EQ(arbitrary.ecus[0].name.identity, 1000u);
  EXPECT_EQ(arbitrary.ecus[1].name.identity, 1001u);
  EXPECT_EQ(arbitrary.ecus[2].name.identity, 0u) << "given on purpose";
  const J1939Config config = good("[[ecu]]\nnumber = 0\n[[ecu]]\nnumber = 1\naddress = 1\n");
  ASSERT_EQ(config.ecus.size(), 2u);
  EXPECT_NE(j1939::compose(config.ecus[0].name), j1939::compose(config.ecus[1].name));
  EXPECT_EQ(J1939Parts::bus_plan(config).sim.nodes.size(), 2u);
}

TEST_F(J1939Configuration, ThePrintedFileIsInOrder) {
  const J1939Config printed = good(config::default_file(j1939_options(), j1939_document_heads.file));
  EXPECT_FALSE(printed.preferred);
  EXPECT_EQ(printed.send.queue, 64);
}

}  // namespace
}  // namespace cansyncd
