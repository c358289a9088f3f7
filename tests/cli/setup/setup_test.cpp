// `setup`: the answers stand in the configuration, the rest of it stays, files are whole or not there, and
// nothing is written over without a word.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>

#include "cli/app/application.h"
#include "cli/setup/configuration_edit.h"

namespace cansync::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kConfiguration = R"(# A line.
[bus]
name = "can7"  # as it was
interface = "can7"
bit_rate = 250000

[sync]
# output = "gpio"

[[slave]]
number = 3  # it answered

[[slave]]
number = 5
name = "old"  # a name
)";

std::string text_of_setup(const fs::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(ConfigurationEdit, PutsAnswersInAndLeavesTheRest) {
  SetupAnswers answers;
  answers.names = {{3, "winder"}, {5, "a \"b\""}};
  answers.sync_output = "can";
  answers.target = "active";
  EXPECT_EQ(edited_configuration(kConfiguration, answers), R"(# A line.
[bus]
name = "can7"  # as it was
interface = "can7"
bit_rate = 250000

[sync]
output = "can"
# output = "gpio"

[[slave]]
number = 3  # it answered
name = "winder"

[[slave]]
number = 5
name = "a \"b\""

[startup]
target = "active"
)");
  EXPECT_EQ(edited_configuration(kConfiguration, {}), kConfiguration);
}

class SetupVerb : public ::testing::Test {
 protected:
  SetupVerb() {
    std::string name = (fs::temp_directory_path() / "cansync_setup.XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
    put("line/can7.toml", kConfiguration);
    put("line/profiles/scanned-3.toml",
        "[profile]\nname = \"scanned-3\"\n[[parameter]]\nnumber = 1\nname = \"a\"\nformat = \"word\"\naccess = "
        "\"read-only\"\n");
    put("line/network/80-can7.network", "[Match]\nName=can7\n");
  }
  ~SetupVerb() override { fs::remove_all(folder_); }

  void put(const std::string& name, const std::string& text) {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << text;
  }
  std::string in_root(const std::string& name) const { return text_of_setup(folder_ / "root" / name); }

  ExitCode run_setup(std::vector<std::string> words) {
    words.insert(words.begin(),
                 {"cansync", "setup", (folder_ / "line").string(), "--root", (folder_ / "root").string()});
    std::vector<const char*> arguments;
    for (const std::string& word : words) arguments.push_back(word.c_str());
    ExitCode code{};
    {
      using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;
      const File out(std::fopen((folder_ / "data").c_str(), "w"), &std::fclose);
      const File told(std::fopen((folder_ / "remarks").c_str(), "w"), &std::fclose);
      code = run(static_cast<int>(arguments.size()), arguments.data(), out.get(), told.get());
    }
    data_ = text_of_setup(folder_ / "data");
    remarks_ = text_of_setup(folder_ / "remarks");
    return code;
  }

  fs::path folder_;
  std::string data_;
  std::string remarks_;
};

TEST_F(SetupVerb, WritesTheFilesOfTheSystem) {
  ASSERT_EQ(run_setup({"--name", "3=winder", "--sync", "can", "--start", "active", "--yes"}), ExitCode::done)
      << remarks_;
  EXPECT_NE(in_root("etc/cansync/can7.toml").find("name = \"winder\""), std::string::npos);
  EXPECT_NE(in_root("etc/cansync/can7.toml").find("output = \"can\""), std::string::npos);
  EXPECT_NE(in_root("etc/cansync/profiles/scanned-3.toml"), "");
  EXPECT_EQ(in_root("etc/systemd/network/80-can7.network"), "[Match]\nName=can7\n");
  EXPECT_NE(remarks_.find("later: systemctl enable --now cansyncd@can7"), std::string::npos) << remarks_;
  // Once more: all is there.
  ASSERT_EQ(run_setup({"--name", "3=winder", "--sync", "can", "--start", "active", "--yes"}), ExitCode::done);
  EXPECT_NE(data_.find("keep "), std::string::npos) << data_;
  EXPECT_EQ(data_.find("write "), std::string::npos) << data_;
}

TEST_F(SetupVerb, ADryRunSaysWhatItWouldDoAndDoesNothing) {
  ASSERT_EQ(run_setup({"--sync", "can", "--dry-run", "--json"}), ExitCode::done) << remarks_;
  EXPECT_NE(data_.find(R"({"action":"run","what":"systemctl enable --now cansyncd@can7","done":false})"),
            std::string::npos)
      << data_;
  EXPECT_FALSE(fs::exists(folder_ / "root"));
}

TEST_F(SetupVerb, WritesNothingOverWithoutAWord) {
  put("root/etc/cansync/can7.toml", "# mine\n");
  EXPECT_EQ(run_setup({"--yes"}), ExitCode::usage);
  EXPECT_NE(remarks_.find("--replace"), std::string::npos) << remarks_;
  EXPECT_EQ(in_root("etc/cansync/can7.toml"), "# mine\n");
  EXPECT_FALSE(fs::exists(folder_ / "root" / "etc" / "cansync" / "profiles"));
  ASSERT_EQ(run_setup({"--yes", "--replace"}), ExitCode::done) << remarks_;
  EXPECT_EQ(in_root("etc/cansync/can7.toml.before-setup"), "# mine\n");
  EXPECT_NE(in_root("etc/cansync/can7.toml"), "# mine\n");
}

TEST_F(SetupVerb, RefusesWhatCannotStand) {
  EXPECT_EQ(run_setup({"--name", "9=x", "--yes"}), ExitCode::usage);
  EXPECT_EQ(run_setup({"--sync", "wire", "--yes"}), ExitCode::usage);
  EXPECT_EQ(run_setup({"--name", "3=old", "--yes"}), ExitCode::failed) << "two slaves of one name";
  EXPECT_FALSE(fs::exists(folder_ / "root"));
  put("line/second.toml", kConfiguration);
  EXPECT_EQ(run_setup({"--yes"}), ExitCode::usage);
}

}  // namespace
}  // namespace cansync::cli
