#include "cli/setup/appliance.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "cli/base/person.h"

namespace cansync::cli {
namespace {

namespace fs = std::filesystem;

struct ApplianceFile {
  const char* path;
  const char* text;
};

/// The names sort behind those of the distribution: of several files the last one wins.
constexpr ApplianceFile kApplianceFiles[] = {
    {"etc/systemd/sleep.conf.d/90-cansync-appliance.conf",
     R"(# Written by `cansync setup --appliance`, removed by `cansync setup --appliance --undo`.
# A computer that sleeps stops the line.
[Sleep]
AllowSuspend=no
AllowHibernation=no
AllowHybridSleep=no
AllowSuspendThenHibernate=no
)"},
    {"etc/systemd/logind.conf.d/90-cansync-appliance.conf",
     R"(# Written by `cansync setup --appliance`, removed by `cansync setup --appliance --undo`.
# A key on the computer does not stop the line; switch it off with `systemctl poweroff`.
[Login]
HandlePowerKey=ignore
HandleSuspendKey=ignore
HandleHibernateKey=ignore
HandleLidSwitch=ignore
IdleAction=ignore
# A shutdown waits so long at most for the daemon to stop the line.
InhibitDelayMaxSec=15
)"},
    {"etc/systemd/system.conf.d/90-cansync-appliance.conf",
     R"(# Written by `cansync setup --appliance`, removed by `cansync setup --appliance --undo`.
# A computer that hangs starts again.
[Manager]
RuntimeWatchdogSec=30s
)"},
    {"etc/apt/apt.conf.d/90cansync-appliance",
     R"(// Written by `cansync setup --appliance`, removed by `cansync setup --appliance --undo`.
// Upgrades are installed; you choose when the computer starts again.
Unattended-Upgrade::Automatic-Reboot "false";
)"},
    {"etc/tmpfiles.d/cansync-appliance.conf",
     R"(# Written by `cansync setup --appliance`, removed by `cansync setup --appliance --undo`.
# Full clock rate, so that the work at the start of an interval always takes the same time.
w /sys/devices/system/cpu/cpu*/cpufreq/scaling_governor - - - - performance
)"},
};

std::vector<std::vector<std::string>> appliance_commands(bool undo) {
  std::vector<std::vector<std::string>> commands = {
      {"systemctl", "daemon-reload"},                            // system.conf
      {"systemctl", "kill", "--signal=HUP", "systemd-logind"}};  // logind.conf
  if (!undo) commands.push_back({"systemd-tmpfiles", "--create", "/etc/tmpfiles.d/cansync-appliance.conf"});
  return commands;
}

bool changes_something(const SetupPlan& plan) {
  return std::any_of(plan.files.begin(), plan.files.end(), [](const PlannedFile& file) {
    return file.kind == PlannedFile::Kind::write || file.kind == PlannedFile::Kind::remove;
  });
}

/// Takes the files out of the plan that somebody has changed, and names them. True: there are some.
bool leave_out_changed(Output& output, SetupPlan& plan, bool undo) {
  const std::vector<std::string> changed = plan.replaced();
  for (const std::string& path : changed) {
    output.remark(
        fmt::format("{} was changed since `cansync setup --appliance` wrote it; it stays as it is. "
                    "Remove it by hand{}",
                    path, undo ? "" : ", then repeat the command"));
  }
  std::erase_if(plan.files, [](const PlannedFile& file) { return file.kind == PlannedFile::Kind::replace; });
  return !changed.empty();
}

}  // namespace

SetupPlan appliance_plan(const fs::path& root, bool undo) {
  SetupPlan plan;
  for (const ApplianceFile& one : kApplianceFiles) {
    PlannedFile file = planned_file(root / one.path, one.text);
    if (undo && file.kind == PlannedFile::Kind::write) continue;  // it is not there
    if (undo && file.kind == PlannedFile::Kind::same) file.kind = PlannedFile::Kind::remove;
    plan.files.push_back(std::move(file));
  }
  if (changes_something(plan)) plan.commands = appliance_commands(undo);
  return plan;
}

ExitCode set_up_appliance(Session& session, const ApplianceTexts& texts) {
  Output& output = session.output();
  SetupPlan plan = appliance_plan(texts.root, texts.undo);
  const ExitCode done = leave_out_changed(output, plan, texts.undo) ? ExitCode::failed : ExitCode::done;
  if (texts.dry_run || !changes_something(plan)) {
    write_plan(output, plan, false);
    if (!changes_something(plan)) output.remark("nothing to do");
    return done;
  }
  const SetupPlan asked = plan;
  std::vector<std::vector<std::string>> later;
  if (!systemd_runs(texts.root)) later.swap(plan.commands);
  if (!texts.yes && !person_agrees(plan_words(asked))) {
    output.remark("ended; nothing was changed");
    return ExitCode::cancelled;
  }
  write_planned_files(plan);
  const bool ran = run_commands(output, plan);
  write_plan(output, plan, ran);
  for (const auto& command : later)
    output.remark(fmt::format("systemd does not run here; later: {}", command_text(command)));
  if (texts.undo) output.remark("the processors keep their governor until the next start of the computer");
  output.remark(texts.undo ? "next: cansync doctor"
                           : "next: cansync doctor; undo with: cansync setup --appliance --undo");
  return ran ? done : ExitCode::failed;
}

}  // namespace cansync::cli
