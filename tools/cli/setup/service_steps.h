#pragma once

#include <string>
#include <vector>

#include "cli/setup/setup_plan.h"

/// How `setup` gets the service of a bus to run with the new configuration, and what it runs with afterwards.
/// Pure; main thread.
namespace cansync::cli {

/// What is known of the service before anything is written.
struct ServiceFacts {
  bool active = false;                     ///< it runs
  bool file_changes = true;                ///< the configuration gets other contents
  std::vector<std::string> needs_restart;  ///< options that change and that a reload leaves as they are
  std::string leading;                     ///< programs that lead its drives, as `leading_writers`
};

/// The commands, and what they interrupt.
struct ServiceSteps {
  std::vector<std::vector<std::string>> commands;
  std::string interrupts;  ///< what stops, in words; empty: nothing
};

/// The unit of the bus on a CAN interface, with the interface's name as systemd writes it: `cansyncd@can0`,
/// `cansyncd@can\x2dwinder`. It belongs to the interface, whatever the name of the bus.
std::string service_unit(const std::string& interface);

/// `configuration`: its file. It is read as the service's user before anything is started.
ServiceSteps service_steps(const std::string& interface, const std::string& configuration,
                           const ServiceFacts& facts);

/// The service runs, by the answer of `systemctl is-active`.
bool is_active(const std::string& answer);

/// What is in force now, as the last line says it. `active`: the service runs; `interface_present`: its CAN
/// interface is there.
std::string in_force_text(const std::string& interface, const std::string& configuration, bool active,
                          bool interface_present);

}  // namespace cansync::cli
