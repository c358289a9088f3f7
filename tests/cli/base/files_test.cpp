#include "cli/base/files.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "cli/text/values.h"

namespace cansync::cli {
namespace {

namespace fs = std::filesystem;

class Files : public testing::Test {
 protected:
  Files() {
    std::string name = (fs::temp_directory_path() / "cansync_files.XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
  }
  ~Files() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  void put(const std::string& name, const std::string& text) const { std::ofstream(path(name)) << text; }
  std::string get(const std::string& name) const {
    std::ifstream file(path(name));
    return {std::istreambuf_iterator<char>(file), {}};
  }
  std::ptrdiff_t files() const {
    return std::distance(fs::directory_iterator(folder_), fs::directory_iterator());
  }

  fs::path folder_;
  static constexpr std::array<std::uint8_t, 3> kData{'n', 'e', 'w'};
};

TEST_F(Files, AReplacementTakesTheTargetsPlaceWhenItIsComplete) {
  put("a", "old content");
  ReplacementFile file(path("a"));
  EXPECT_EQ(get("a"), "old content");
  file.commit(kData);
  EXPECT_EQ(get("a"), "new");
  EXPECT_EQ(files(), 1);
}

TEST_F(Files, OtherContentsAreKept) {
  const auto write = [this] { return ReplacementFile(path("a")).commit_and_keep(kData); };
  EXPECT_EQ(write(), "");
  EXPECT_EQ(write(), "") << "the same contents";
  put("a", "the only good backup");
  EXPECT_EQ(write(), path("a.1"));
  EXPECT_EQ(get("a.1"), "the only good backup");
  EXPECT_EQ(get("a"), "new");
  put("a", "newer");  // longer than what is written
  EXPECT_EQ(write(), path("a.2"));
  EXPECT_EQ(get("a.1"), "the only good backup");
  EXPECT_EQ(get("a.2"), "newer");
  put("a", "ne");
  EXPECT_EQ(write(), path("a.3"));
  EXPECT_EQ(files(), 4);
}

TEST_F(Files, WhatIsThereIsRefusedWithoutForce) {
  EXPECT_NO_THROW(expect_new_file(path("a"), "FILE", false));
  EXPECT_NO_THROW(expect_new_file("-", "FILE", false));
  EXPECT_NO_THROW(expect_new_file("/dev/null", "FILE", false));
  put("a", "");
  EXPECT_NO_THROW(expect_new_file(path("a"), "FILE", false)) << "nothing is lost";
  put("a", "rows");
  EXPECT_NO_THROW(expect_new_file(path("a"), "FILE", true));
  try {
    expect_new_file(path("a"), "--write", false);
    ADD_FAILURE() << "it was not refused";
  } catch (const UsageError& error) {
    EXPECT_EQ(std::string(error.what()),
              "--write: '" + path("a") +
                  "' is there already, with 4 bytes; allowed: another name, or --force to "
                  "replace it");
  }
}

TEST_F(Files, AReplacementGetsTheUsualPermissions) {
  const mode_t mask = ::umask(022);
  ReplacementFile file(path("a"));
  file.commit(kData);
  ::umask(mask);
  struct stat found {};
  ASSERT_EQ(::stat(path("a").c_str(), &found), 0);
  EXPECT_EQ(found.st_mode & 0777u, 0644u);
}

TEST_F(Files, AnIncompleteReplacementLeavesNoTrace) {
  put("a", "old content");
  { const ReplacementFile file(path("a")); }
  EXPECT_EQ(get("a"), "old content");
  EXPECT_EQ(files(), 1);
}

TEST_F(Files, AMissingFolderIsNoticedAtOnce) {
  EXPECT_THROW(ReplacementFile(path("missing/a")), std::system_error);
}

TEST_F(Files, AFolderOrDeviceIsNeverReplaced) {
  EXPECT_THROW(ReplacementFile(folder_.string()), UsageError);
  EXPECT_THROW(ReplacementFile("/dev/null"), UsageError);
}

TEST_F(Files, ReadsUpToTheLimit) {
  put("a", "12345");
  EXPECT_EQ(read_file(path("a"), 5).size(), 5u);
  EXPECT_THROW(read_file(path("a"), 4), UsageError);
}

TEST_F(Files, RefusesWhatIsEmptyOrMissing) {
  put("empty", "");
  EXPECT_THROW(read_file(path("empty"), 10), UsageError);
  EXPECT_THROW(read_file(path("missing"), 10), std::system_error);
}

}  // namespace
}  // namespace cansync::cli
