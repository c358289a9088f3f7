#include "cli/setup/service_steps.h"

#include <fmt/format.h>

namespace cansync::cli {

std::string service_unit(const std::string& interface) {
  return "cansyncd@" + interface;
}

ServiceSteps service_steps(const std::string& interface, const std::string& configuration,
                           const ServiceFacts& facts) {
  const std::string unit = service_unit(interface);
  ServiceSteps steps;
  // What root may read the service may not: the check of the service's user is the one that counts.
  steps.commands.push_back({"runuser", "-u", "cansync", "--", "cansyncd", "--check", configuration});
  steps.commands.push_back({"systemctl", "enable", unit});
  if (!facts.active) {
    // Without its interface the unit waits: starting it would wait here, too.
    if (facts.interface_present) steps.commands.push_back({"systemctl", "start", unit});
    return steps;
  }
  if (!facts.file_changes) return steps;
  if (facts.needs_restart.empty()) {
    steps.commands.push_back({"systemctl", "reload", unit});
    return steps;
  }
  steps.commands.push_back({"systemctl", "restart", unit});
  std::string options;
  for (const std::string& option : facts.needs_restart) options += (options.empty() ? "" : ", ") + option;
  steps.interrupts = fmt::format(
      "{} runs, and these options take effect at a restart: {}. The restart stops SYNC and the reference values "
      "of its bus; the drives report a fault{}{}",
      unit, options, facts.leading.empty() ? "" : ". ", facts.leading);
  return steps;
}

ServiceEnd service_end(const std::string& is_active) {
  if (is_active.starts_with("active") || is_active.starts_with("reloading")) return ServiceEnd::active;
  return is_active.starts_with("failed") || is_active.starts_with("activating") ? ServiceEnd::failed
                                                                                : ServiceEnd::inactive;
}

std::string in_force_text(const std::string& interface, const std::string& configuration,
                          const ServiceFacts& before, ServiceEnd end) {
  const std::string unit = service_unit(interface);
  switch (end) {
    case ServiceEnd::active:
      return fmt::format("{} runs with {}, and starts at every boot", unit, configuration);
    case ServiceEnd::inactive:
      if (before.interface_present) break;
      return fmt::format("{} waits for the interface {}, and starts with {} when the interface appears", unit,
                         interface, configuration);
    case ServiceEnd::failed:
      break;
  }
  return fmt::format("{} does not run; `journalctl -u {}` shows why", unit, unit);
}

}  // namespace cansync::cli
