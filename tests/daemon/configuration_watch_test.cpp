// Configurations that have run, and the file on disk beside the one that runs.
#include "daemon/configuration_watch.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "daemon/kept_configurations.h"

namespace cansyncd {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kStart = 1795813493;  // 2026-11-27 21:04:53 UTC

/// A folder of the test's own, removed at the end.
class ConfigurationFiles : public testing::Test {
 protected:
  ConfigurationFiles() { fs::create_directories(folder_); }
  ~ConfigurationFiles() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  /// Each text has another length: file systems need not tell two writes of one moment apart.
  void write(const std::string& name, const std::string& text) const { std::ofstream(path(name)) << text; }
  std::vector<std::string> texts(const std::string& name) const {
    std::vector<std::string> texts;
    for (const KeptConfiguration& kept : KeptConfigurations(folder_.string()).of(path(name)))
      texts.push_back(kept.text);
    return texts;
  }
  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_)) names.push_back(entry.path().filename());
    std::sort(names.begin(), names.end());
    return names;
  }

 private:
  const fs::path folder_ = fs::temp_directory_path() / ("configuration_watch_" + std::to_string(getpid()));
};

using KeptConfigurationFiles = ConfigurationFiles;

TEST_F(KeptConfigurationFiles, TheNewestIsFirstWhateverTheClockSays) {
  const KeptConfigurations kept(path(""));
  for (const std::string text : {"a", "b", "b", "c", "a"})
    EXPECT_EQ(kept.keep("/etc/can0.toml", text), std::nullopt);
  fs::last_write_time(path("can0.4.toml"), fs::file_time_type{});
  EXPECT_EQ(texts("can0.toml"), (std::vector<std::string>{"a", "c", "b", "a"}));
}

TEST_F(KeptConfigurationFiles, SoManyAreKeptAndNoOtherFileIsTouched) {
  for (const char* other : {"can0.toml", "can0.x.toml", "can01.1.toml", "can0.1.2.toml", "can0.1.toml.old"})
    write(other, "other");
  const KeptConfigurations kept(path(""));
  for (unsigned i = 0; i < 25; ++i) EXPECT_EQ(kept.keep("can0.toml", std::to_string(i)), std::nullopt);
  EXPECT_EQ(texts("can0.toml").size(), KeptConfigurations::kMost);
  EXPECT_EQ(texts("can0.toml").front(), "24");
  EXPECT_EQ(texts("can0.toml").back(), "15");
  EXPECT_EQ(texts("can01.toml"), (std::vector<std::string>{"other"}));
  EXPECT_EQ(files().size(), KeptConfigurations::kMost + 5);
}

TEST_F(KeptConfigurationFiles, AFolderThatIsNotThereIsNamed) {
  const auto failed = KeptConfigurations(path("none")).keep("can0.toml", "a");
  ASSERT_TRUE(failed);
  EXPECT_EQ(*failed, path("none/can0.1.toml") + ": No such file or directory");
  fs::create_directory(path("none"));
  EXPECT_EQ(KeptConfigurations(path("none")).keep("can0.toml", "a"), std::nullopt) << "by the next reload";
  EXPECT_TRUE(KeptConfigurations("").of("can0.toml").empty());
  EXPECT_EQ(KeptConfigurations("").keep("can0.toml", "a"), std::nullopt);
}

/// Every text that holds "wrong" is wrong in line 2.
LoadedConfig load(const config::Source& source) {
  LoadedConfig loaded;
  loaded.path = source.path;
  loaded.text = source.text;
  if (!source.text || source.text->find("wrong") != std::string::npos)
    loaded.problems = {{{source.path, 2, 1}, "bus.name", "is wrong"}};
  return loaded;
}

TEST_F(ConfigurationFiles, AFileThatIsNotWhatRunsIsFoundAndItsErrorNamed) {
  write("can0.toml", "good");
  const std::string file = path("can0.toml");
  ConfigurationWatch watch(load(config::read_source(file)), load, kStart);
  EXPECT_FALSE(watch.look());
  EXPECT_EQ(watch.reason(), "");
  write("can0.toml", "also good");
  EXPECT_TRUE(watch.look());
  EXPECT_EQ(watch.reason(), "runs the configuration of 2026-11-27 21:04:53 UTC; " + file +
                                " has changed: reload the daemon, or restart it");
  EXPECT_FALSE(watch.wrong());
  EXPECT_FALSE(watch.look()) << "said once";
  write("can0.toml", "wrong since today");
  EXPECT_TRUE(watch.look());
  EXPECT_EQ(watch.reason(),
            "runs the configuration of 2026-11-27 21:04:53 UTC; " + file + ":2:1: bus.name: is wrong");
  EXPECT_TRUE(watch.wrong());
  fs::remove(file);
  EXPECT_FALSE(watch.look()) << "no other reason than before";
  EXPECT_TRUE(watch.wrong());
  write("can0.toml", "good");
  EXPECT_TRUE(watch.look());
  EXPECT_EQ(watch.reason(), "");
  EXPECT_FALSE(watch.differs());
}

TEST_F(ConfigurationFiles, AKeptOneSaysSinceWhenItIsKnown) {
  write("can0.toml", "wrong");
  LoadedConfig running = load({path("can0.toml"), "good"});
  running.kept_since = "2025-01-02 03:04:05 UTC";
  ConfigurationWatch watch(running, load, kStart);
  EXPECT_TRUE(watch.look());
  EXPECT_EQ(watch.reason(), "runs the configuration of 2025-01-02 03:04:05 UTC; " + path("can0.toml") +
                                ":2:1: bus.name: is wrong");
}

TEST_F(ConfigurationFiles, AReloadIsInForceButForWhatItLeaves) {
  write("can0.toml", "good");
  ConfigurationWatch watch(load(config::read_source(path("can0.toml"))), load, kStart);
  write("can0.toml", "another one");
  watch.taken("another one", "not changed before a restart: bus.name", kStart + 1);
  EXPECT_TRUE(watch.look());
  EXPECT_EQ(watch.reason(), path("can0.toml") + ": not changed before a restart: bus.name");
  EXPECT_TRUE(watch.differs());
  watch.taken("another one", "", kStart + 2);
  EXPECT_TRUE(watch.look());
  EXPECT_EQ(watch.reason(), "");
}

TEST_F(ConfigurationFiles, AProfileThatIsMissingIsSaidUntilAReloadHasIt) {
  write("can0.toml", "good");
  LoadedConfig running = load(config::read_source(path("can0.toml")));
  running.profile_problems = {{{"can0.toml", 3, 11}, "slave.3.profile", "no profile 'drive'"}};
  ConfigurationWatch watch(running, load, kStart);
  EXPECT_TRUE(watch.look());
  EXPECT_EQ(watch.reason(),
            "runs without a drive profile, its names and limits: can0.toml:3:11: slave.3.profile: no profile "
            "'drive'");
  EXPECT_FALSE(watch.differs());
  watch.taken("good", "", kStart);
  EXPECT_TRUE(watch.look());
  EXPECT_EQ(watch.reason(), "");
}

}  // namespace
}  // namespace cansyncd
