// `setup`: the answers stand in the configuration, the rest of it stays, files are whole or not there, and
// nothing is written over without a word.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>

#include "cli/app/application.h"
#include "cli/doctor/doctor_host.h"
#include "cli/setup/configuration_edit.h"
#include "cli/setup/service_steps.h"

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
name = "a \"b\""  # a name

[startup]
target = "active"
)");
  EXPECT_EQ(edited_configuration(kConfiguration, {}), kConfiguration);
}

TEST(ConfigurationEdit, KeepsCommentsInlineTablesAndDottedKeys) {
  SetupAnswers answers;
  answers.names = {{3, "winder"}, {5, "new # one"}};
  answers.sync_output = "can";
  answers.target = "active";
  EXPECT_EQ(edited_configuration("sync.output = 'none'   # no wire\n"
                                 "startup = { target = \"setup\", lost_after = 3 }  # wait\n"
                                 "[[slave]]\n"
                                 "  name = \"a \\\" # b\"  # the left one\n"
                                 "  number = 3\n"
                                 "[[slave]]\n"
                                 "number = 5\n"
                                 "name = \"old\"# tight\n",
                                 answers),
            "sync.output = \"can\"   # no wire\n"
            "startup = { target = \"active\", lost_after = 3 }  # wait\n"
            "[[slave]]\n"
            "  name = \"winder\"  # the left one\n"
            "  number = 3\n"
            "[[slave]]\n"
            "number = 5\n"
            "name = \"new # one\"# tight\n");
}

TEST(ConfigurationEdit, WhatItCannotEditIsSaidWithLineAndText) {
  const auto problem = [](const std::string& text, const SetupAnswers& answers) -> std::string {
    try {
      return "edited: " + edited_configuration(text, answers);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
  };
  SetupAnswers answers;
  answers.target = "active";
  EXPECT_NE(problem("[bus]\nname = \"x\"\n[startup]\ntarget = \"\"\"setup\"\"\"\n", answers).find("line 4"),
            std::string::npos);
  const std::string inline_table = problem("startup = { lost_after = 3 }\n", answers);
  EXPECT_NE(inline_table.find("line 1"), std::string::npos) << inline_table;
  EXPECT_NE(inline_table.find("`target = \"active\"`"), std::string::npos) << inline_table;
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
    words.insert(words.begin(), (folder_ / "line").string());
    return run_verb(std::move(words));
  }
  ExitCode run_verb(std::vector<std::string> words) {
    words.insert(words.begin(), {"cansync", "setup", "--root", (folder_ / "root").string()});
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
  EXPECT_NE(remarks_.find("later: systemctl disable systemd-networkd-wait-online.service"), std::string::npos)
      << remarks_;
  EXPECT_NE(remarks_.find("later: systemctl enable cansyncd@can7"), std::string::npos) << remarks_;
  // Once more: all is there.
  ASSERT_EQ(run_setup({"--name", "3=winder", "--sync", "can", "--start", "active", "--yes"}), ExitCode::done);
  EXPECT_NE(data_.find("keep "), std::string::npos) << data_;
  EXPECT_EQ(data_.find("write "), std::string::npos) << data_;
  // Where networkd was in use before, what waits for it stays.
  fs::create_directories(folder_ / "root/etc/systemd/system/multi-user.target.wants");
  fs::create_symlink("/lib/systemd/system/systemd-networkd.service",
                     folder_ / "root/etc/systemd/system/multi-user.target.wants/systemd-networkd.service");
  ASSERT_EQ(run_setup({"--yes"}), ExitCode::usage) << "the answers are others";
  ASSERT_EQ(run_setup({"--name", "3=winder", "--sync", "can", "--start", "active", "--yes"}), ExitCode::done);
  EXPECT_EQ(remarks_.find("wait-online"), std::string::npos) << remarks_;
}

TEST_F(SetupVerb, ADryRunSaysWhatItWouldDoAndDoesNothing) {
  ASSERT_EQ(run_setup({"--sync", "can", "--dry-run", "--json"}), ExitCode::done) << remarks_;
  EXPECT_NE(data_.find(R"({"action":"run","what":"systemctl enable cansyncd@can7","done":false})"),
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

/// The unit is bound to the device of its instance: one named after another word would wait for it for ever.
TEST_F(SetupVerb, FileAndServiceAreThoseOfTheInterface) {
  std::string text = kConfiguration;
  text.replace(text.find("name = \"can7\""), std::string_view("name = \"can7\"").size(), "name = \"press\"");
  put("line/can7.toml", text);
  ASSERT_EQ(run_setup({"--yes"}), ExitCode::done) << remarks_;
  EXPECT_NE(in_root("etc/cansync/can7.toml").find("name = \"press\""), std::string::npos);
  EXPECT_FALSE(fs::exists(folder_ / "root/etc/cansync/press.toml"));
  EXPECT_NE(remarks_.find("later: systemctl enable cansyncd@can7"), std::string::npos) << remarks_;
  EXPECT_NE(remarks_.find("next: cansync --bus press doctor"), std::string::npos) << "clients know the name";
}

TEST_F(SetupVerb, TheUsersOfTheServicesReadTheFilesWhateverTheUmask) {
  const mode_t before = ::umask(0077);
  const ExitCode code = run_setup({"--yes"});
  ::umask(before);
  ASSERT_EQ(code, ExitCode::done) << remarks_;
  for (const auto& entry : fs::recursive_directory_iterator(folder_ / "root"))
    EXPECT_EQ(static_cast<unsigned>(entry.status().permissions()), entry.is_directory() ? 0755u : 0644u)
        << entry.path();
}

TEST_F(SetupVerb, NoServiceRunsASimulatedBus) {
  put("line/can7.toml", "[bus]\ninterface = \"sim\"\n[[slave]]\nnumber = 3\n");
  EXPECT_EQ(run_setup({"--yes"}), ExitCode::usage);
  EXPECT_NE(remarks_.find("bus.interface: found \"sim\""), std::string::npos) << remarks_;
  EXPECT_FALSE(fs::exists(folder_ / "root"));
}

using Commands = std::vector<std::vector<std::string>>;

const Commands kFirstSteps = {
    {"runuser", "-u", "cansync", "--", "cansyncd", "--check", "/etc/cansync/can7.toml"},
    {"systemctl", "enable", "cansyncd@can7"}};

ServiceSteps steps_for(const ServiceFacts& facts) {
  return service_steps("can7", "/etc/cansync/can7.toml", facts);
}

Commands and_then(std::vector<std::string> last) {
  Commands commands = kFirstSteps;
  commands.push_back(std::move(last));
  return commands;
}

TEST(ServiceSteps, AServiceThatDoesNotRunIsStarted) {
  EXPECT_EQ(steps_for({}).commands, and_then({"systemctl", "start", "cansyncd@can7"}));
}

TEST(ServiceSteps, TheUnitIsNamedAsSystemdWritesTheInterface) {
  EXPECT_EQ(service_unit("can0"), "cansyncd@can0");
  EXPECT_EQ(service_unit("can-winder"), "cansyncd@can\\x2dwinder");
  EXPECT_EQ(service_unit("vcan.1@2_x"), "cansyncd@vcan.1\\x402_x");
  EXPECT_EQ(service_unit("k\xc3\xa4n"), "cansyncd@k\\xc3\\xa4n");
  EXPECT_EQ(service_unit(".can"), "cansyncd@\\x2ecan");
  EXPECT_EQ(in_force_text("can-winder", "/etc/cansync/can-winder.toml", false, true),
            "'cansyncd@can\\x2dwinder' does not run; `journalctl -u 'cansyncd@can\\x2dwinder'` shows why")
      << "to be typed into a shell";
}

TEST(ServiceSteps, AServiceThatRunsTakesTheNewFile) {
  ServiceFacts facts{.active = true, .file_changes = true};
  EXPECT_EQ(steps_for(facts).commands, and_then({"systemctl", "reload", "cansyncd@can7"}));
  EXPECT_EQ(steps_for(facts).interrupts, "");
  facts.needs_restart = {"bus.bit_rate", "sync.output"};
  const ServiceSteps restarted = steps_for(facts);
  EXPECT_EQ(restarted.commands, and_then({"systemctl", "restart", "cansyncd@can7"}));
  EXPECT_NE(restarted.interrupts.find("bus.bit_rate, sync.output"), std::string::npos);
  EXPECT_TRUE(restarted.interrupts.ends_with(
      "stops SYNC and the reference values of its bus; the drives report a fault"))
      << restarted.interrupts;
  facts.leading = "'plc' gives the reference values of telegram 1";
  EXPECT_TRUE(
      steps_for(facts).interrupts.ends_with("a fault. 'plc' gives the reference values of telegram 1"));
  facts.file_changes = false;
  EXPECT_EQ(steps_for(facts).commands, kFirstSteps) << "it runs with this file";
}

TEST(ServiceSteps, TheLastLineSaysWhatIsInForce) {
  const auto told = [](const char* answer, bool interface_present) {
    return in_force_text("can7", "/etc/cansync/can7.toml", is_active(answer), interface_present);
  };
  EXPECT_EQ(told("active\n", true),
            "cansyncd@can7 runs with /etc/cansync/can7.toml, and starts at every boot");
  EXPECT_TRUE(told("active\n", false).ends_with("; it waits for the interface can7"));
  for (const char* ended : {"failed\n", "activating\n", "inactive\n", ""})
    EXPECT_NE(told(ended, true).find("does not run"), std::string::npos) << ended;
}

TEST_F(SetupVerb, RefusesWhatCannotStand) {
  EXPECT_EQ(run_setup({"--name", "9=x", "--yes"}), ExitCode::usage);
  EXPECT_EQ(run_setup({"--sync", "wire", "--yes"}), ExitCode::usage);
  EXPECT_EQ(run_setup({"--name", "3=old", "--yes"}), ExitCode::failed) << "two slaves of one name";
  EXPECT_FALSE(fs::exists(folder_ / "root"));
  put("line/second.toml", kConfiguration);
  EXPECT_EQ(run_setup({"--yes"}), ExitCode::usage);
}

using SetupAppliance = SetupVerb;

constexpr const char* kApplianceFiles[] = {"etc/systemd/sleep.conf.d/90-cansync-appliance.conf",
                                           "etc/systemd/logind.conf.d/90-cansync-appliance.conf",
                                           "etc/systemd/system.conf.d/90-cansync-appliance.conf",
                                           "etc/apt/apt.conf.d/90cansync-appliance",
                                           "etc/tmpfiles.d/cansync-appliance.conf"};

TEST_F(SetupAppliance, WritesAndNamesEachFileAndTheDoctorIsContent) {
  put("root/etc/apt/apt.conf.d/50unattended-upgrades", "Unattended-Upgrade::Automatic-Reboot \"true\";\n");
  ASSERT_EQ(run_verb({"--appliance", "--yes"}), ExitCode::done) << remarks_;
  for (const char* file : kApplianceFiles) {
    EXPECT_NE(in_root(file), "") << file;
    EXPECT_NE(data_.find(std::string("write ") + (folder_ / "root" / file).string()), std::string::npos)
        << data_;
  }
  EXPECT_NE(remarks_.find("later: systemctl kill --signal=HUP systemd-logind"), std::string::npos)
      << remarks_;
  const HostFacts host = read_host(folder_ / "root");
  EXPECT_EQ(host.sleeps, std::vector<std::string>());
  EXPECT_EQ(host.reboot_setting, "");
  EXPECT_EQ(host.watchdog_set, "30s");
  // The second time changes nothing, and undoing leaves what was there before.
  ASSERT_EQ(run_verb({"--appliance", "--yes"}), ExitCode::done);
  EXPECT_EQ(data_.find("write "), std::string::npos) << data_;
  EXPECT_NE(remarks_.find("nothing to do"), std::string::npos) << remarks_;
  ASSERT_EQ(run_verb({"--appliance", "--undo", "--yes"}), ExitCode::done) << remarks_;
  for (const char* file : kApplianceFiles) EXPECT_FALSE(fs::exists(folder_ / "root" / file)) << file;
  EXPECT_NE(in_root("etc/apt/apt.conf.d/50unattended-upgrades"), "");
  ASSERT_EQ(run_verb({"--appliance", "--undo", "--yes"}), ExitCode::done);
  EXPECT_NE(remarks_.find("nothing to do"), std::string::npos) << remarks_;
}

TEST_F(SetupAppliance, ADryRunAndAQuestionThatNobodyAnswersChangeNothing) {
  ASSERT_EQ(run_verb({"--appliance", "--dry-run"}), ExitCode::done);
  EXPECT_NE(data_.find("run systemctl daemon-reload"), std::string::npos) << data_;
  EXPECT_FALSE(fs::exists(folder_ / "root"));
  EXPECT_EQ(run_verb({"--appliance"}), ExitCode::usage);
  EXPECT_NE(remarks_.find("--yes"), std::string::npos) << remarks_;
  EXPECT_FALSE(fs::exists(folder_ / "root"));
}

TEST_F(SetupAppliance, AFileThatSomebodyHasChangedStays) {
  ASSERT_EQ(run_verb({"--appliance", "--yes"}), ExitCode::done) << remarks_;
  put(std::string("root/") + kApplianceFiles[1], "# mine\n");
  EXPECT_EQ(run_verb({"--appliance", "--yes"}), ExitCode::failed);
  EXPECT_EQ(run_verb({"--appliance", "--undo", "--yes"}), ExitCode::failed);
  EXPECT_NE(remarks_.find("90-cansync-appliance.conf was changed"), std::string::npos) << remarks_;
  EXPECT_EQ(in_root(kApplianceFiles[1]), "# mine\n");
  EXPECT_FALSE(fs::exists(folder_ / "root" / kApplianceFiles[0]));
}

TEST_F(SetupAppliance, NeedsNoFolderAndTakesNone) {
  EXPECT_EQ(run_verb({}), ExitCode::usage);
  EXPECT_EQ(run_setup({"--appliance", "--yes"}), ExitCode::usage);
  EXPECT_EQ(run_setup({"--undo", "--yes"}), ExitCode::usage);
}

}  // namespace
}  // namespace cansync::cli
