#include "cli/setup/service_steps.h"

#include <fmt/format.h>

#include "text/unit_name.h"

namespace cansync::cli {

std::string service_unit(const std::string& interface) {
  return "cansyncd@" + text::unit_instance(interface);
}

ServiceSteps service_steps(const std::string& interface, const std::string& configuration,
                           const ServiceFacts& facts) {
  const std::string unit = service_unit(interface);
  ServiceSteps steps;
  // What root may read the service may not: the check of the service's user is the one that counts.
  steps.commands.push_back({"runuser", "-u", "cansync", "--", "cansyncd", "--check", configuration});
  steps.commands.push_back({"systemctl", "enable", unit});
  if (!facts.active) {
    steps.commands.push_back({"systemctl", "start", unit});
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
      text::shell_word(unit), options, facts.leading.empty() ? "" : ". ", facts.leading);
  return steps;
}

bool is_active(const std::string& answer) {
  return answer.starts_with("active") || answer.starts_with("reloading");
}

std::string in_force_text(const std::string& interface, const std::string& configuration, bool active,
                          bool interface_present) {
  const std::string unit = text::shell_word(service_unit(interface));
  if (!active) return fmt::format("{0} does not run; `journalctl -u {0}` shows why", unit);
  return fmt::format("{} runs with {}, and starts at every boot{}", unit, configuration,
                     interface_present ? "" : fmt::format("; it waits for the interface {}", interface));
}

}  // namespace cansync::cli
