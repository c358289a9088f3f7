// The drive profiles that a configuration names.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "config_text.h"
#include "daemon/cansync/config/reload.h"

namespace cansyncd {
namespace {

namespace fs = std::filesystem;

constexpr const char* kProfile =
    "[profile]\nname = \"drive\"\n[[parameter]]\nnumber = 12\nname = \"speed-limit\"\nformat = \"word\"\n"
    "access = \"read-write\"\nmaximum = 100\n";

/// A configuration's folder with profiles in it, removed at the end.
class Folder {
 public:
  Folder() : path_(fs::temp_directory_path() / ("profile_config_" + std::to_string(getpid()))) {
    fs::remove_all(path_);
    fs::create_directories(path_ / "profiles");
  }
  ~Folder() { fs::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::string add(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name) << text;
    return (path_ / name).string();
  }
  /// The configuration of one slave with this profile.
  ConfigFile load(const std::string& profile, const std::vector<std::string>& overrides = {}) const {
    return load_config(add("line.toml", "[[slave]]\nnumber = 3\nprofile = \"" + profile + "\"\n"), overrides);
  }
  std::string file(const std::string& name) const { return (path_ / name).string(); }

 private:
  fs::path path_;
};

TEST(ProfileConfig, AProfileIsFoundByNameBesideTheConfiguration) {
  const Folder folder;
  folder.add("profiles/drive.toml", kProfile);
  const ConfigFile loaded = folder.load("drive");
  ASSERT_EQ(problems_text(loaded.problems), "");
  ASSERT_NE(loaded.config.slaves[3].parameters, nullptr);
  EXPECT_EQ(loaded.config.slaves[3].parameters->find(12)->name, "speed-limit");
  EXPECT_EQ(loaded.config.slaves[0].parameters, nullptr);
}

TEST(ProfileConfig, AFileCountsFromTheConfiguration) {
  const Folder folder;
  folder.add("drive.toml", kProfile);
  EXPECT_EQ(problems_text(folder.load("./drive.toml").problems), "");
  EXPECT_EQ(problems_text(folder.load("drive.toml").problems), "");
  EXPECT_EQ(problems_text(folder.load("", {"slave.3.profile=" + folder.file("drive.toml")}).problems), "");
}

TEST(ProfileConfig, AMissingOneIsNamedWithEveryFolder) {
  const Folder folder;
  EXPECT_EQ(problems_text(folder.load("drive").problems),
            folder.file("line.toml") +
                ":3:11: slave.3.profile: no profile 'drive': there is no drive.toml in " +
                folder.file("profiles") +
                ", /etc/cansync/profiles, /usr/local/share/cansync/profiles, /usr/share/cansync/profiles\n");
  EXPECT_EQ(problems_text(folder.load("./none.toml").problems),
            folder.file("./none.toml") + ": cannot read this profile: No such file or directory\n");
  EXPECT_EQ(problems_text(folder.load("Drive 5").problems),
            folder.file("line.toml") +
                ":3:11: slave.3.profile: found \"Drive 5\"; allowed: 1..64 lower-case letters, digits and "
                "'-', or a file with '/' or .toml\n");
}

TEST(ProfileConfig, AWrongOneIsToldOnceWithLineAndColumn) {
  const Folder folder;
  folder.add("profiles/drive.toml", std::string(kProfile) + "minimum = 101\nunits = 3\n");
  const std::string line = folder.add("line.toml",
                                      "[[slave]]\nnumber = 1\nprofile = \"drive\"\n[[slave]]\nnumber = "
                                      "2\nprofile = \"drive\"\n");
  const std::string text = problems_text(load_config(line, {}).problems);
  const std::string profile = folder.file("profiles/drive.toml");
  EXPECT_TRUE(text.starts_with(profile + ":9:11: parameter.minimum: found 101, over the maximum 100;"))
      << text;
  EXPECT_NE(text.find("\n" + profile + ":10:1: parameter.units: no key of this section;"), std::string::npos)
      << text;
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 2) << text;
}

TEST(ProfileConfig, SlavesOfOneProfileShareIt) {
  const Folder folder;
  folder.add("profiles/drive.toml", kProfile);
  const std::string line = folder.add("line.toml",
                                      "[[slave]]\nnumber = 1\nprofile = \"drive\"\n[[slave]]\nnumber = "
                                      "2\nprofile = \"drive\"\n");
  const Config config = load_config(line, {}).config;
  EXPECT_EQ(config.slaves[1].parameters, config.slaves[2].parameters);
}

TEST(ProfileConfig, AReloadReadsTheFileAgain) {
  const Folder folder;
  folder.add("profiles/drive.toml", kProfile);
  const ConfigFile running = folder.load("drive");
  folder.add("profiles/drive.toml", std::string(kProfile) + "minimum = 7\n");
  const ConfigReload plan = plan_reload(running, folder.load("drive"));
  ASSERT_EQ(problems_text(plan.merged.problems), "");
  EXPECT_EQ(plan.merged.config.slaves[3].parameters->find(12)->minimum, 7);
}

}  // namespace
}  // namespace cansyncd
