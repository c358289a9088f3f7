#include "daemon/cansync/state_text.h"

#include <fmt/format.h>

#include "cansync/settings/mode.h"

namespace cansyncd {

std::string state_text(const MasterSnapshot& master) {
  const bool silent = !cansync::is_synchronous(master.state);
  if (silent && master.access == cansync::BusAccess::other_master) return "silent: another master on the bus";
  if (master.waits_for_command) return "waiting for a command: another master was on the bus";
  if (master.access == cansync::BusAccess::listening) return "listening for another master";
  if (silent && master.waits_for_upper_sync) return "waiting for the SYNC of the upper bus";
  return std::string(name(master.state));
}

std::string other_master_frame(std::uint32_t identifier) {
  return identifier == 0 ? std::string("a SYNC frame") : fmt::format("identifier 0x{:03X}", identifier);
}

}  // namespace cansyncd
