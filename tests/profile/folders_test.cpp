// Where profiles are looked for.
#include "profile/folders.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace profile {
namespace {

namespace fs = std::filesystem;

TEST(ProfileFolders, TheFirstFolderWithTheFileWins) {
  const fs::path base = fs::temp_directory_path() / ("profile_folders_" + std::to_string(getpid()));
  fs::create_directories(base / "one");
  fs::create_directories(base / "two");
  const std::vector<std::string> folders = {(base / "one").string(), (base / "two").string()};
  EXPECT_EQ(find_file("drive", folders).problem,
            "no profile 'drive': there is no drive.toml in " + folders[0] + ", " + folders[1]);
  std::ofstream(base / "two" / "drive.toml").put('#');
  EXPECT_EQ(find_file("drive", folders).path, (base / "two" / "drive.toml").string());
  std::ofstream(base / "one" / "drive.toml").put('#');
  EXPECT_EQ(find_file("drive", folders).path, (base / "one" / "drive.toml").string());
  EXPECT_EQ(find_file("drive", folders).problem, "");
  fs::remove_all(base);
}

TEST(ProfileFolders, APathIsNoName) {
  EXPECT_TRUE(is_path("./drive"));
  EXPECT_TRUE(is_path("drive.toml"));
  EXPECT_FALSE(is_path("drive"));
}

}  // namespace
}  // namespace profile
