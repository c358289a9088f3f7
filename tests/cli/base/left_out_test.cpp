#include "cli/base/left_out.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

namespace cansync::cli {
namespace {

using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

/// The lines of remarks after telling `count` of them, and two that are not kept.
std::size_t lines_of(std::size_t count, bool json, const std::string& file) {
  const File remarks(std::tmpfile(), &std::fclose);
  Output output(stdout, remarks.get(), json);
  tell_left_out(output, file, std::vector<std::string>(count, "f:1:1: wrong"), count > 5 ? 2 : 0);
  std::size_t lines = 0;
  std::rewind(remarks.get());
  for (int c = std::fgetc(remarks.get()); c != EOF; c = std::fgetc(remarks.get())) lines += c == '\n' ? 1 : 0;
  return lines;
}

TEST(LeftOut, TenAreShownAndTheOthersCounted) {
  EXPECT_EQ(lines_of(25, false, "a"), 11u);
  EXPECT_EQ(lines_of(25, true, "b"), 26u) << "a program gets all, and how many were not kept";
  EXPECT_EQ(lines_of(3, false, "c"), 3u);
  EXPECT_EQ(lines_of(0, false, "d"), 0u);
  EXPECT_EQ(lines_of(25, false, "a"), 0u) << "each file once in a verb";
  EXPECT_EQ(end_of_verb(ExitCode::done), ExitCode::in_part);
}

TEST(LeftOut, AVerbThatIsDoneEndsInPartAndTheNextBeginsAnew) {
  EXPECT_EQ(end_of_verb(ExitCode::done), ExitCode::done);
  (void)lines_of(1, false, "a");
  EXPECT_EQ(end_of_verb(ExitCode::timeout), ExitCode::timeout) << "what failed counts more";
  EXPECT_EQ(end_of_verb(ExitCode::done), ExitCode::done);
  (void)lines_of(1, false, "a");
  EXPECT_EQ(end_of_verb(ExitCode::done), ExitCode::in_part);
}

}  // namespace
}  // namespace cansync::cli
