#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cli/setup/setup_plan.h"

/// How `setup` gets the service of a bus to run with the new configuration, and what it runs with afterwards.
/// Pure; main thread.
namespace cansync::cli {

/// What is known of the service before anything is written.
struct ServiceFacts {
  bool active = false;                     ///< it runs
  bool interface_present = false;          ///< its CAN interface is there
  bool file_changes = true;                ///< the configuration gets other contents
  std::vector<std::string> needs_restart;  ///< options that change and that a reload leaves as they are
  std::string leading;                     ///< programs that lead its drives, as `leading_writers`
};

/// The commands, and what they interrupt.
struct ServiceSteps {
  std::vector<std::vector<std::string>> commands;
  std::string interrupts;  ///< what stops, in words; empty: nothing
};

/// The unit of the bus on a CAN interface: it belongs to the interface, whatever the name of the bus.
std::string service_unit(const std::string& interface);

/// `configuration`: its file. It is read as the service's user before anything is started.
ServiceSteps service_steps(const std::string& interface, const std::string& configuration,
                           const ServiceFacts& facts);

/// How the service is afterwards, as `systemctl is-active` says it.
enum class ServiceEnd : std::uint8_t { active, inactive, failed };
ServiceEnd service_end(const std::string& is_active);

/// What is in force now, as the last line says it.
std::string in_force_text(const std::string& interface, const std::string& configuration,
                          const ServiceFacts& before, ServiceEnd end);

}  // namespace cansync::cli
