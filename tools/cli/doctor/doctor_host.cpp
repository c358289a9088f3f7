#include "cli/doctor/doctor_host.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <system_error>

#include "text/counts.h"

namespace cansync::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRemedy =
    "cansync setup --appliance   (docs/operations.md, \"A PC that runs a machine\")";

std::string trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  const auto first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return std::string(text.substr(first, text.find_last_not_of(kBlank) - first + 1));
}

/// Files of folders by their names: of two of one name the one of the first folder counts, as systemd has it.
std::map<std::string, fs::path> files_by_name(const std::vector<fs::path>& folders) {
  std::map<std::string, fs::path> files;
  std::error_code none;
  for (const fs::path& folder : folders) {
    for (const auto& entry : fs::directory_iterator(folder, none))
      files.emplace(entry.path().filename().string(), entry.path());
  }
  return files;
}

void take_setting(const fs::path& path, std::string_view key, std::optional<std::string>& value) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    const auto sign = line.find('=');
    if (sign == std::string::npos || trimmed(std::string_view(line).substr(0, sign)) != key) continue;
    value = trimmed(std::string_view(line).substr(sign + 1));
  }
}

/// systemd takes these words for no, and 0.
bool is_off(const std::string& value) {
  constexpr std::array kWords = {"", "0", "no", "n", "false", "f", "off"};
  return std::find(kWords.begin(), kWords.end(), value) != kWords.end();
}

/// A unit that nobody can start: its name is a link to /dev/null.
bool is_masked(const fs::path& root, const std::string& unit) {
  for (const char* folder : {"etc/systemd/system", "run/systemd/system"}) {
    std::error_code none;
    if (fs::read_symlink(root / folder / unit, none) == "/dev/null") return true;
  }
  return false;
}

std::vector<std::string> allowed_sleeps(const fs::path& root) {
  struct Sleep {
    const char* name;
    const char* key;
  };
  constexpr Sleep kSleeps[] = {{"suspend", "AllowSuspend"},
                               {"hibernate", "AllowHibernation"},
                               {"hybrid-sleep", "AllowHybridSleep"},
                               {"suspend-then-hibernate", "AllowSuspendThenHibernate"}};
  std::vector<std::string> allowed;
  if (is_masked(root, "sleep.target")) return allowed;
  for (const auto& [name, key] : kSleeps) {
    if (is_masked(root, std::string(name) + ".target")) continue;
    if (const auto value = systemd_setting(root, "sleep.conf", key); value && is_off(*value)) continue;
    allowed.emplace_back(name);
  }
  return allowed;
}

/// The text of apt's setting in one line of a file; nothing: the line does not set it.
std::optional<std::string> reboot_value(std::string_view line) {
  constexpr std::string_view kKey = "Unattended-Upgrade::Automatic-Reboot";
  const std::string text = trimmed(line);
  if (!text.starts_with(kKey)) return std::nullopt;  // a comment, or something else
  const std::string_view rest = std::string_view(text).substr(kKey.size());
  if (rest.empty() || (rest.front() != ' ' && rest.front() != '\t' && rest.front() != '"'))
    return std::nullopt;  // Automatic-Reboot-Time
  const auto begin = rest.find('"');
  if (begin == std::string_view::npos) return std::nullopt;
  return std::string(rest.substr(begin + 1, rest.find('"', begin + 1) - begin - 1));
}

/// apt reads its files in the order of their names; the last one wins.
std::string reboot_setting(const fs::path& root) {
  std::string allowed_by;
  std::map<std::string, fs::path> files = files_by_name({root / "etc/apt/apt.conf.d"});
  for (const auto& [name, path] : files) {
    std::ifstream file(path);
    for (std::string line; std::getline(file, line);) {
      if (const auto value = reboot_value(line))
        allowed_by = is_off(*value) || *value == "without" || *value == "disable" ? "" : path.string();
    }
  }
  if (allowed_by.empty()) return {};
  return "/" + fs::path(allowed_by).lexically_relative(root).string();
}

std::map<std::string, int> governors(const fs::path& root) {
  std::map<std::string, int> found;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(root / "sys/devices/system/cpu", none)) {
    std::ifstream file(entry.path() / "cpufreq/scaling_governor");
    if (std::string name; std::getline(file, name)) ++found[name];
  }
  return found;
}

/// logind leaves a file for each lock, with lines NAME=VALUE.
std::set<std::uint32_t> processes_that_keep_awake(const fs::path& root) {
  std::set<std::uint32_t> processes;
  for (const auto& [name, path] : files_by_name({root / "run/systemd/inhibit"})) {
    std::error_code none;
    if (!fs::is_regular_file(path, none)) continue;  // a pipe for each lock, too: reading it never ends
    std::optional<std::string> what;
    std::optional<std::string> mode;
    std::optional<std::string> process;
    take_setting(path, "WHAT", what);
    take_setting(path, "MODE", mode);
    take_setting(path, "PID", process);
    if (!what || !process || mode != "block" || what->find("sleep") == std::string::npos) continue;
    processes.insert(static_cast<std::uint32_t>(std::strtoul(process->c_str(), nullptr, 10)));
  }
  return processes;
}

void look_at_sleep(const HostFacts& host, FindingList& out) {
  if (!host.systemd)
    out.ok("sleep", "systemd does not run here: its settings are not looked at");
  else if (host.sleeps.empty())
    out.ok("sleep", "this computer does not sleep: every way to do so is switched off");
  else
    out.warning(
        "sleep",
        fmt::format("this computer may sleep ({}), which stops the line", fmt::join(host.sleeps, ", ")),
        kRemedy);
}

void look_at_reboots(const HostFacts& host, FindingList& out) {
  if (!host.unattended)
    out.ok("automatic reboot", "unattended-upgrades is not installed");
  else if (host.reboot_setting.empty())
    out.ok("automatic reboot", "unattended-upgrades does not reboot this computer");
  else
    out.warning("automatic reboot",
                "unattended-upgrades may reboot this computer (" + host.reboot_setting + ")", kRemedy);
}

void look_at_governor(const HostFacts& host, FindingList& out) {
  constexpr const char* kFast = "performance";
  if (host.governors.empty()) {
    out.ok("governor", "the kernel changes no clock rate of a processor here");
  } else if (host.governors.size() == 1 && host.governors.begin()->first == kFast) {
    out.ok("governor", "performance on every processor");
  } else {
    std::vector<std::string> slow;
    for (const auto& [name, processors] : host.governors)
      if (name != kFast)
        slow.push_back(fmt::format("{} on {}", name,
                                   text::counted(static_cast<std::uint64_t>(processors), "processor")));
    out.warning(
        "governor",
        fmt::format("{}: the clock rate is lower when a processor is idle, so that work at the start of "
                    "an interval takes longer",
                    fmt::join(slow, ", ")),
        kRemedy);
  }
}

void look_at_watchdog(const HostFacts& host, FindingList& out) {
  if (!host.systemd || !host.watchdog_device)
    out.ok("watchdog", "this computer has no hardware watchdog that systemd could feed");
  else if (host.watchdog_set)
    out.ok("watchdog", fmt::format("hardware watchdog, RuntimeWatchdogSec={}", *host.watchdog_set));
  else
    out.warning("watchdog",
                "there is a hardware watchdog, and systemd does not use it: a computer that hangs stays so",
                kRemedy);
}

}  // namespace

std::optional<std::string> systemd_setting(const fs::path& root, std::string_view name,
                                           std::string_view key) {
  std::optional<std::string> value;
  take_setting(root / "etc/systemd" / name, key, value);
  const std::string folder = fmt::format("systemd/{}.d", name);
  for (const auto& [file, path] :
       files_by_name({root / "etc" / folder, root / "run" / folder, root / "usr/lib" / folder})) {
    if (file.ends_with(".conf")) take_setting(path, key, value);
  }
  return value;
}

HostFacts read_host(const fs::path& root) {
  HostFacts facts;
  facts.systemd = fs::exists(root / "run/systemd/system");
  facts.sleeps = allowed_sleeps(root);
  facts.unattended = fs::exists(root / "usr/bin/unattended-upgrade");
  facts.reboot_setting = reboot_setting(root);
  facts.governors = governors(root);
  facts.watchdog_device = fs::exists(root / "dev/watchdog0");
  facts.watchdog_set = systemd_setting(root, "system.conf", "RuntimeWatchdogSec");
  if (facts.watchdog_set && is_off(*facts.watchdog_set)) facts.watchdog_set.reset();
  facts.keep_awake = processes_that_keep_awake(root);
  return facts;
}

void look_at_inhibitors(const HostFacts& host, std::uint32_t process, bool in_run, FindingList& out) {
  if (!host.systemd)
    out.ok("inhibitors", "systemd does not run here: nothing keeps this computer from sleeping");
  else if (host.keep_awake.count(process) != 0)
    out.ok("inhibitors", "the daemon keeps this computer from sleeping, and a shutdown waits for the line");
  else if (!in_run)
    out.ok("inhibitors", "none: the line is not in run");
  else
    out.warning(
        "inhibitors", "the line is in run, and the daemon does not keep this computer from sleeping",
        "cansync events --code sleep_not_inhibited; apt install polkitd, or: cansync setup --appliance");
}

void look_at_host(const HostFacts& host, FindingList& out) {
  look_at_sleep(host, out);
  look_at_reboots(host, out);
  look_at_governor(host, out);
  look_at_watchdog(host, out);
}

}  // namespace cansync::cli
