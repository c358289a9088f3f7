// Files that are no configuration, or a wrong one: where, what, and what is allowed.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "config_text.h"

namespace cansyncd {
namespace {

namespace fs = std::filesystem;

TEST(WrongConfig, AMissingFileIsNamed) {
  const ConfigFile file = load_config("/no/such/file.toml", {});
  ASSERT_EQ(file.problems.size(), 1U);
  EXPECT_EQ(to_string(file.problems[0]),
            "/no/such/file.toml: cannot read this file: No such file or directory");
}

TEST(WrongConfig, AFolderIsNoFile) {
  const ConfigFile file = load_config("/", {});
  ASSERT_EQ(file.problems.size(), 1U);
  EXPECT_NE(to_string(file.problems[0]).find("/: cannot read this file: it is a folder"), std::string::npos);
}

TEST(WrongConfig, WhatIsNoTextFileIsRefusedUnread) {
  const auto problem_of = [](const char* path) { return problems_text(load_config(path, {}).problems); };
  EXPECT_EQ(problem_of("/dev/zero"),
            "/dev/zero: cannot read this file: it is a device, pipe or socket; allowed: a text file\n");
  const fs::path big = fs::temp_directory_path() / ("config_test_big_" + std::to_string(getpid()));
  std::ofstream(big).put('x');
  fs::resize_file(big, std::uintmax_t{100} * 1024 * 1024);
  EXPECT_EQ(problem_of(big.c_str()),
            big.string() +
                ": cannot read this file: it has over 262144 bytes; allowed: a text file of up to 262144 "
                "bytes\n");
  fs::remove(big);
}

TEST(WrongConfig, WhatIsNoTomlHasAPlace) {
  const auto problem_of = [](const std::string& text) { return problems_text(from_text(text).problems); };
  EXPECT_TRUE(problem_of(std::string("\0\1", 2)).starts_with("test.toml:1:1: this is not TOML: "))
      << "binary";
  EXPECT_TRUE(problem_of(std::string("[bus]\nname = \"a\0b\"\n", 18)).starts_with("test.toml:2:10: "));
  EXPECT_TRUE(problem_of("[bus]\nname = \"a\xFF\"\n").starts_with("test.toml:2:9: ")) << "no UTF-8";
  EXPECT_TRUE(problem_of("a = " + std::string(100'000, '[')).starts_with("test.toml:1:")) << "nested lists";
  std::string inline_tables = "a = ";
  for (int i = 0; i < 100'000; ++i) inline_tables += "{a = ";
  EXPECT_TRUE(problem_of(inline_tables).starts_with("test.toml:1:")) << "nested tables";
}

TEST(WrongConfig, AKeyOfVeryManyPartsIsRefusedBeforeItTakesTheStack) {
  constexpr const char* kDeep =
      ": found a key of more than 16 parts; allowed: [section], [[section]], key = value, # comment\n";
  std::string deep = "a";
  for (int i = 0; i < 100'000; ++i) deep += ".a";
  EXPECT_EQ(problems_text(from_text("\n" + deep + " = 1\n").problems), std::string("test.toml:2:2") + kDeep);
  EXPECT_EQ(problems_text(from_text("[" + deep + "]\n").problems), std::string("test.toml:1:3") + kDeep);
  EXPECT_EQ(problems_text(from_text(kSmallest, {deep + "=1"}).problems).find("--set"), 0U);
  // Parts that each fit, in tables within each other.
  std::string nested = "b";
  for (int i = 0; i < 20; ++i) nested += " = {a.a";
  EXPECT_NE(problems_text(from_text(nested + " = 1" + std::string(20, '}') + "\n").problems).find(kDeep),
            std::string::npos);
}

TEST(WrongConfig, AtMostTwentyProblemsAreShown) {
  std::string text = "[[slave]]\nnumber = 0\n[bus]\n";
  for (int i = 0; i < 25; ++i) text += "wrong" + std::to_string(i) + " = 1\n";
  const std::string shown = problems_text(from_text(text).problems);
  EXPECT_EQ(std::count(shown.begin(), shown.end(), '\n'), 21);
  EXPECT_TRUE(shown.ends_with("and 5 more problems\n"));
}

/// Each file says at its end what is to be found in it: "# expect LINE:COLUMN: TEXT", in order and complete.
class WrongFile : public testing::TestWithParam<fs::path> {};

TEST_P(WrongFile, IsRefusedWithPlaceAndReason) {
  std::istringstream lines(content(GetParam()));
  std::vector<std::string> expected;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("# expect ")) expected.push_back(line.substr(9));
  }
  ASSERT_FALSE(expected.empty());
  const ConfigFile file = load_config(GetParam().string(), {});
  ASSERT_EQ(file.problems.size(), expected.size()) << problems_text(file.problems);
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const Problem& found = file.problems[i];
    const std::string text = std::to_string(found.where.line) + ":" + std::to_string(found.where.column) +
                             ": " + config::to_string({{}, found.key, found.text});
    EXPECT_EQ(text.substr(0, expected[i].size()), expected[i]);
    EXPECT_EQ(found.where.file, GetParam().string());
  }
}

std::vector<fs::path> wrong_files() {
  std::vector<fs::path> out;
  for (const auto& entry : fs::directory_iterator(CANSYNC_SOURCE_DIR "/tests/cansync/config/wrong_configs")) {
    out.push_back(entry.path());
  }
  std::sort(out.begin(), out.end());
  return out;
}

std::string case_name(const testing::TestParamInfo<fs::path>& file) {
  return file.param.stem().string();
}

INSTANTIATE_TEST_SUITE_P(Table, WrongFile, testing::ValuesIn(wrong_files()), case_name);

}  // namespace
}  // namespace cansyncd
