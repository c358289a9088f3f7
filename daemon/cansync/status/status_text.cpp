#include "daemon/cansync/status/status_text.h"

#include <fmt/format.h>

#include <string_view>

#include "cansync/settings/mode.h"
#include "cansync/settings/timing.h"
#include "daemon/cansync/state_text.h"
#include "daemon/status/status_line.h"
#include "text/counts.h"

namespace cansyncd {
namespace {

constexpr int kNamesShown = 4;

/// "; no answer from winder, cutter and 3 more"; empty when every configured slave responds.
std::string missing_slaves(const MasterSnapshot& master, const Config& config) {
  std::string names;
  int missing = 0;
  const cansync::SlaveMask silent{config.master.configured().bits & ~master.responding.bits};
  for (const cansync::SlaveNumber slave : silent) {
    if (++missing > kNamesShown) continue;
    names += (names.empty() ? "" : ", ") + config.slaves[slave.value()].name;
  }
  if (missing == 0) return {};
  if (missing > kNamesShown) names += fmt::format(" and {} more", missing - kNamesShown);
  return "; no answer from " + names;
}

/// What to do about another master; empty when none keeps the daemon from sending.
std::string other_master_problem(const MasterSnapshot& master, const Config& config) {
  const std::string state = state_text(master);
  if (master.waits_for_command && !master.second_master)
    return fmt::format("{} of interface {}; start with: cansync mode setup", state, config.bus.interface);
  if (!master.second_master || cansync::is_synchronous(master.state)) return {};
  return fmt::format("{} of interface {} ({}); switch one of them off", state, config.bus.interface,
                     other_master_frame(master.second_master_identifier));
}

}  // namespace

std::string status_text(const MasterSnapshot& master, const Config& config) {
  if (std::string problem = bus_problem(master.controller, config.bus); !problem.empty()) return problem;
  if (std::string problem = other_master_problem(master, config); !problem.empty()) return problem;
  const auto& times = cansync::slot_times(config.master.bit_rate);
  return fmt::format("{}: {}{}; bus {} ({}) at {} bit/s{}", state_text(master),
                     text::counted_of(__builtin_popcount(master.responding.bits),
                                      __builtin_popcount(config.master.configured().bits), "slave responds",
                                      "slaves respond"),
                     missing_slaves(master, config), config.bus.name, config.bus.interface,
                     times.bits_per_second, master.second_master ? "; another master sends" : "");
}

}  // namespace cansyncd
