#include "cansync/config/check_sync.h"

#include <fmt/format.h>

#include <array>
#include <string_view>

namespace cansyncd {
namespace {

/// Identifiers that CANsync itself uses.
struct Range {
  std::uint32_t first;
  std::uint32_t last;
  std::string_view use;
};
constexpr auto kUsed = std::to_array<Range>({
    {0x010, 0x010, "action commands"},
    {0x100, 0x1FF, "reference value telegrams"},
    {0x300, 0x3FF, "actual value telegrams"},
    {0x500, 0x5FF, "commands and responses"},
});

}  // namespace

std::optional<std::string> wrong_sync_identifier(const SyncConfig& sync) {
  if (!sync.uses_frame()) return std::nullopt;
  for (const Range& range : kUsed) {
    if (sync.can_identifier < range.first || sync.can_identifier > range.last) continue;
    return fmt::format(
        "found 0x{:03X}, which CANsync uses for {}; allowed: 0x001..0x7FF outside 0x010, "
        "0x100..0x1FF, 0x300..0x3FF, 0x500..0x5FF",
        sync.can_identifier, range.use);
  }
  return std::nullopt;
}

std::string sync_warning(const Config& config) {
  const SyncConfig& sync = config.sync;
  const bool real = config.bus.kind != BusKind::simulated;
  const bool silent = sync.output == SyncOutput::none && sync.input == SyncInput::none;
  if (!real || !silent || config.startup.target != StartTarget::active) return "";
  return fmt::format(
      "warning: no SYNC: startup.target is \"active\", and sync.output and sync.input are \"none\": no drive on {} "
      "locks unless another device makes SYNC; set sync.output = \"gpio\", \"phc\" or \"can\" where this computer "
      "makes it, or sync.input = \"gpio\", \"pps\" or \"can\" where it follows another source\n",
      config.bus.interface);
}

}  // namespace cansyncd
