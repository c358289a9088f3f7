#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "cli/base/finding_list.h"

/// What could stop a line from outside on this computer: sleep, automatic reboots, slow processors, a
/// computer that hangs. Looked up in the settings of systemd and apt; "A PC that runs a machine" in
/// docs/operations.md describes them.
namespace cansync::cli {

struct HostFacts {
  bool systemd = false;                     ///< systemd runs here
  std::vector<std::string> sleeps;          ///< ways to sleep that are allowed, such as "suspend"
  bool unattended = false;                  ///< unattended-upgrades is installed
  std::string reboot_setting;               ///< file that allows it to reboot; empty: it may not
  std::map<std::string, int> governors;     ///< of the processors, with how many have it; empty: none has one
  bool watchdog_device = false;             ///< there is a hardware watchdog
  std::optional<std::string> watchdog_set;  ///< RuntimeWatchdogSec of systemd; nothing: not set, or off
  std::set<std::uint32_t> keep_awake;  ///< processes whose lock of logind keeps the computer from sleeping
};

/// Value of `key` in the file `name` of /etc/systemd and the folders NAME.d of systemd, where the last file in
/// the order of their names wins; nothing: none has it. `root`: before every path, "/" is the computer.
std::optional<std::string> systemd_setting(const std::filesystem::path& root, std::string_view name,
                                           std::string_view key);

/// What cannot be read is left unknown; nothing throws for it. `root`: as above.
HostFacts read_host(const std::filesystem::path& root);

/// Whether the daemon keeps the computer awake. `process`: its number; `in_run`: the line is in run.
void look_at_inhibitors(const HostFacts& host, std::uint32_t process, bool in_run, FindingList& out);

/// Appends what was found.
void look_at_host(const HostFacts& host, FindingList& out);

}  // namespace cansync::cli
