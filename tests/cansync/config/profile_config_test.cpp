// The drive profiles that a configuration names.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "cansync/config/reload.h"
#include "config_text.h"
#include "profile/passport.h"

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
  ASSERT_EQ(problems_text(loaded.profile_problems), "");
  ASSERT_NE(loaded.config.slaves[3].parameters, nullptr);
  EXPECT_EQ(loaded.config.slaves[3].parameters->find(12)->name, "speed-limit");
  EXPECT_EQ(loaded.config.slaves[0].parameters, nullptr);
}

TEST(ProfileConfig, AFileCountsFromTheConfiguration) {
  const Folder folder;
  folder.add("drive.toml", kProfile);
  EXPECT_EQ(problems_text(folder.load("./drive.toml").profile_problems), "");
  EXPECT_EQ(problems_text(folder.load("drive.toml").profile_problems), "");
  EXPECT_EQ(problems_text(folder.load("", {"slave.3.profile=" + folder.file("drive.toml")}).profile_problems),
            "");
}

TEST(ProfileConfig, AMissingOneIsNamedWithEveryFolder) {
  const Folder folder;
  EXPECT_EQ(problems_text(folder.load("drive").problems), "") << "it costs names and limits, not the start";
  EXPECT_EQ(folder.load("drive").config.slaves[3].parameters, nullptr);
  EXPECT_EQ(problems_text(folder.load("drive").profile_problems),
            folder.file("line.toml") +
                ":3:11: slave.3.profile: no profile 'drive': there is no drive.toml in " +
                folder.file("profiles") +
                ", /etc/cansync/profiles, /usr/local/share/cansync/profiles, /usr/share/cansync/profiles\n");
  EXPECT_EQ(problems_text(folder.load("./none.toml").profile_problems),
            folder.file("./none.toml") + ": cannot read this profile: No such file or directory\n");
  EXPECT_EQ(problems_text(folder.load("Drive 5").profile_problems),
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
  const std::string text = problems_text(load_config(line, {}).profile_problems);
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

// --- who the drive is

constexpr const char* kIdentityProfile =
    "[profile]\nname = \"drive\"\nrecognised_by = [\"12=4400\"]\n"
    "[[parameter]]\nnumber = 12\nname = \"device-type\"\nformat = \"word\"\naccess = \"read-only\"\n"
    "identity = \"type\"\n"
    "[[parameter]]\nnumber = 13\nname = \"rating\"\nformat = \"word\"\naccess = \"read-only\"\n"
    "unit = \"A\"\nfactor = 0.1\nsigned = true\n"
    "[[parameter]]\nnumber = 14\nname = \"serial-number\"\nformat = \"doubleword\"\naccess = \"read-only\"\n"
    "identity = \"unit\"\n";

/// The values that slave 3 with this profile is expected to have.
std::vector<cansync::ParameterValue> expected(const Folder& folder, const std::string& list) {
  folder.add("profiles/drive.toml", kIdentityProfile);
  const ConfigFile loaded = load_config(
      folder.add("line.toml", "[[slave]]\nnumber = 3\nprofile = \"drive\"\nexpect = [" + list + "]\n"), {});
  EXPECT_EQ(problems_text(loaded.problems), "");
  const auto values = cansync::expected_of(loaded.config.master.slaves[3]);
  return {values.begin(), values.end()};
}

cansync::ParameterValue value_of(unsigned number, std::uint32_t value) {
  return {*cansync::ParameterNumber::from(number), value};
}

TEST(ExpectConfig, TakesNumbersNamesInTheirUnitAndRawOnes) {
  const Folder folder;
  EXPECT_EQ(expected(folder, R"("0x0E=0x12345678", "rating=-1.5", "device-type=0x1130")"),
            (std::vector{value_of(14, 0x12345678), value_of(13, 0xFFF1), value_of(12, 4400)}));
}

TEST(ExpectConfig, TakesWhatTheProfileIsRecognisedByAndEachNumberOnce) {
  const Folder folder;
  EXPECT_EQ(expected(folder, R"("profile", "12=4400", "14=7")"),
            (std::vector{value_of(12, 4400), value_of(14, 7)}));
}

TEST(ExpectConfig, TakesThoseLinesOfAPassportThatTellWhoTheDriveIs) {
  const Folder folder;
  profile::Passport passport;
  passport.bus = "can0";
  passport.profile = "drive";
  passport.profile_hash = "00";
  passport.entries = {{.number = 12, .name = "device-type", .raw = 4400, .identity = profile::Identity::type},
                      {.number = 13, .name = "rating", .raw = 7},
                      {.number = 14,
                       .name = "serial-number",
                       .format = profile::Format::doubleword,
                       .raw = 70000,
                       .identity = profile::Identity::unit}};
  folder.add("winder.txt", profile::passport_text(passport));
  EXPECT_EQ(expected(folder, R"("passport winder.txt")"),
            (std::vector{value_of(12, 4400), value_of(14, 70000)}));
  folder.add("winder.txt", profile::passport_text(passport) + " ");
  const std::string problem = problems_text(load_config(folder.file("line.toml"), {}).problems);
  EXPECT_NE(problem.find("line.toml:4:10: slave.3.expect: "), std::string::npos) << problem;
}

TEST(ExpectConfig, APassportThatTellsNothingIsRefused) {
  const Folder folder;
  profile::Passport passport;
  passport.bus = "can0";
  passport.profile = "drive";
  passport.profile_hash = "00";
  folder.add("winder.txt", profile::passport_text(passport));
  const ConfigFile loaded =
      load_config(folder.add("line.toml", "[[slave]]\nnumber = 3\nexpect = [\"passport winder.txt\"]\n"), {});
  EXPECT_NE(problems_text(loaded.problems).find("found no line 'type' or 'unit' with a value"),
            std::string::npos);
}

}  // namespace
}  // namespace cansyncd
