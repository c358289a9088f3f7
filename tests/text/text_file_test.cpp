#include "text/text_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace {

namespace fs = std::filesystem;

class TextFile : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "text_file_test.XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder = pattern;
  }
  void TearDown() override { fs::remove_all(folder); }

  std::string write(const std::string& name, const std::string& content) {
    std::string path = (folder / name).string();
    std::ofstream(path, std::ios::binary) << content;
    return path;
  }
  static std::string problem(const std::string& path, std::size_t most = text::kFileLimit) {
    const auto found = text::read_file(path, most);
    const auto* wrong = std::get_if<text::FileProblem>(&found);
    return wrong == nullptr ? "" : wrong->text;
  }

  fs::path folder;
};

TEST_F(TextFile, IsReadAsItIs) {
  const std::string content("a\0b\r\n\xFF", 6);
  const auto found = text::read_file(write("f", content));
  ASSERT_TRUE(std::holds_alternative<std::string>(found));
  EXPECT_EQ(std::get<std::string>(found), content);
  EXPECT_EQ(std::get<std::string>(text::read_file(write("empty", ""))), "");
}

TEST_F(TextFile, UpToTheLimitAndNoFurther) {
  const std::string path = write("f", std::string(100, 'x'));
  EXPECT_EQ(problem(path, 100), "");
  EXPECT_EQ(problem(path, 99), "it has over 99 bytes; allowed: a text file of up to 99 bytes");
}

TEST_F(TextFile, AHundredMegabytesAreRefusedUnread) {
  const std::string path = write("big", "");
  fs::resize_file(path, std::uintmax_t{100} * 1024 * 1024);
  EXPECT_EQ(problem(path), "it has over 262144 bytes; allowed: a text file of up to 262144 bytes");
}

TEST_F(TextFile, WhatIsNoFileIsRefusedAtOnce) {
  EXPECT_EQ(problem(folder.string()), "it is a folder");
  EXPECT_EQ(problem("/dev/zero"), "it is a device, pipe or socket; allowed: a text file");
  const std::string pipe = (folder / "pipe").string();
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(problem(pipe), "it is a device, pipe or socket; allowed: a text file");
}

TEST_F(TextFile, WhatTheSystemRefusesIsTold) {
  EXPECT_EQ(problem((folder / "none").string()), "No such file or directory");
  EXPECT_EQ(problem((folder / std::string(5000, 'x')).string()), "File name too long");
  EXPECT_EQ(problem(""), "No such file or directory");
}

TEST_F(TextFile, WithoutTheRightToReadItIsTold) {
  const std::string path = write("f", "a");
  ASSERT_EQ(chmod(path.c_str(), 0), 0);
  // Root may read everything, nobody may not.
  const bool root = geteuid() == 0;
  constexpr uid_t kNobody = 65534;
  if (root) {
    ASSERT_EQ(seteuid(kNobody), 0);
  }
  const std::string found = problem(path);
  if (root) {
    ASSERT_EQ(seteuid(0), 0);
  }
  EXPECT_EQ(found, "Permission denied");
}

TEST_F(TextFile, AFileOfTheKernelIsReadThoughItSaysItIsEmpty) {
  const auto found = text::read_file("/proc/self/status");
  ASSERT_TRUE(std::holds_alternative<std::string>(found));
  EXPECT_TRUE(std::get<std::string>(found).starts_with("Name:"));
}

}  // namespace
