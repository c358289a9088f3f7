#include "cli/doctor/doctor_host.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

/// Settings of a made-up computer.
namespace cansync::cli {
namespace {

namespace fs = std::filesystem;

using Sleeps = std::vector<std::string>;

class Host : public testing::Test {
 protected:
  Host() : root_(fs::path(testing::TempDir()) / ("cansync_host_" + std::to_string(getpid()))) {
    fs::remove_all(root_);
    fs::create_directories(root_ / "run/systemd/system");
  }
  ~Host() override { fs::remove_all(root_); }
  void write(const std::string& path, const std::string& text) const {
    fs::create_directories((root_ / path).parent_path());
    std::ofstream(root_ / path) << text;
  }
  void mask(const std::string& unit) const {
    fs::create_directories(root_ / "etc/systemd/system");
    fs::create_symlink("/dev/null", root_ / "etc/systemd/system" / unit);
  }
  HostFacts facts() const { return read_host(root_); }

  const fs::path root_;
};

TEST_F(Host, OfDebiansDefaultsMaySleep) {
  EXPECT_TRUE(facts().systemd);
  EXPECT_EQ(facts().sleeps, Sleeps({"suspend", "hibernate", "hybrid-sleep", "suspend-then-hibernate"}));
  EXPECT_FALSE(facts().unattended);
  EXPECT_EQ(facts().reboot_setting, "");
  EXPECT_FALSE(facts().watchdog_set);
}

TEST_F(Host, SleepIsOffByMaskedTargetsOrBySettings) {
  mask("suspend.target");
  write("etc/systemd/sleep.conf", "[Sleep]\n#AllowSuspend=yes\nAllowHibernation = no\n");
  EXPECT_EQ(facts().sleeps, Sleeps({"hybrid-sleep", "suspend-then-hibernate"}));
  mask("sleep.target");
  EXPECT_EQ(facts().sleeps, Sleeps());
}

TEST_F(Host, TheLastFileOfSystemdWins) {
  write("etc/systemd/system.conf", "[Manager]\nRuntimeWatchdogSec=5s\n");
  write("usr/lib/systemd/system.conf.d/10-vendor.conf", "[Manager]\nRuntimeWatchdogSec=10s\n");
  EXPECT_EQ(facts().watchdog_set, "10s");
  write("etc/systemd/system.conf.d/90-ours.conf", "[Manager]\nRuntimeWatchdogSec=30s\n");
  write("etc/systemd/system.conf.d/99-note.txt", "RuntimeWatchdogSec=1s\n");
  EXPECT_EQ(facts().watchdog_set, "30s");
  // A file of one name in /etc stands for the one of the vendor.
  write("etc/systemd/system.conf.d/10-vendor.conf", "");
  write("etc/systemd/system.conf.d/90-ours.conf", "[Manager]\nRuntimeWatchdogSec=off\n");
  EXPECT_FALSE(facts().watchdog_set);
}

TEST_F(Host, AptsLastFileDecidesAboutReboots) {
  write("usr/bin/unattended-upgrade", "");
  write("etc/apt/apt.conf.d/50unattended-upgrades",
        "//Unattended-Upgrade::Automatic-Reboot \"false\";\n"
        "Unattended-Upgrade::Automatic-Reboot-Time \"02:00\";\n"
        "  Unattended-Upgrade::Automatic-Reboot \"true\";\n");
  EXPECT_TRUE(facts().unattended);
  EXPECT_EQ(facts().reboot_setting, "/etc/apt/apt.conf.d/50unattended-upgrades");
  write("etc/apt/apt.conf.d/90ours", "Unattended-Upgrade::Automatic-Reboot \"false\";\n");
  EXPECT_EQ(facts().reboot_setting, "");
}

TEST_F(Host, GovernorsAreCounted) {
  for (const char* one : {"cpu0", "cpu1"})
    write(std::string("sys/devices/system/cpu/") + one + "/cpufreq/scaling_governor", "schedutil\n");
  write("sys/devices/system/cpu/cpu2/cpufreq/scaling_governor", "performance\n");
  const std::map<std::string, int> expected = {{"schedutil", 2}, {"performance", 1}};
  EXPECT_EQ(facts().governors, expected);
}

TEST_F(Host, LocksOfLogindAreKnownByTheirProcess) {
  const std::string rest = "UID=997\nWHO=cansyncd\nWHY=the line is in run\nFIFO=/run/systemd/inhibit/1.ref\n";
  write("run/systemd/inhibit/1", "WHAT=shutdown\nMODE=delay\nPID=70\n" + rest);
  write("run/systemd/inhibit/2", "WHAT=sleep:idle:handle-power-key\nMODE=delay\nPID=71\n" + rest);
  write("run/systemd/inhibit/3", "WHAT=sleep:idle:handle-power-key\nMODE=block\nPID=72\n" + rest);
  ASSERT_EQ(::mkfifo((root_ / "run/systemd/inhibit/3.ref").c_str(), 0600), 0);  // as logind has them
  EXPECT_EQ(facts().keep_awake, std::set<std::uint32_t>({72}));
  for (const bool in_run : {false, true}) {
    FindingList out;
    look_at_inhibitors(facts(), 72, in_run, out);
    look_at_inhibitors(facts(), 70, in_run, out);
    const auto findings = std::move(out).take();
    ASSERT_EQ(findings.size(), 2u);
    EXPECT_EQ(findings[0].level, Level::ok);
    EXPECT_EQ(findings[1].level, in_run ? Level::warning : Level::ok);
  }
}

TEST_F(Host, NothingIsWrongWhereNothingIsKnown) {
  FindingList out;
  look_at_host(read_host(root_ / "empty"), out);
  for (const Finding& finding : std::move(out).take()) EXPECT_EQ(finding.level, Level::ok) << finding.topic;
}

}  // namespace
}  // namespace cansync::cli
