#include "daemon/cansync/config/check_sync.h"

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

std::vector<SyncProblem> check_sync(const SyncConfig& sync) {
  std::vector<SyncProblem> problems;
  if (sync.output == SyncOutput::phc && sync.input != SyncInput::none) {
    problems.push_back({"sync.input",
                        "found an input beside output = \"phc\"; allowed: \"none\", because the timeline "
                        "follows the hardware clock (let PTP discipline that clock instead)"});
  }
  if (sync.output == SyncOutput::can && sync.input == SyncInput::can) {
    problems.push_back({"sync.input",
                        "found \"can\" beside output = \"can\"; allowed: only one of them, because one bus "
                        "carries one software SYNC"});
  }
  if (sync.output == SyncOutput::gpio && sync.input == SyncInput::gpio &&
      sync.gpio_chip == sync.input_gpio_chip && sync.gpio_line == sync.input_gpio_line) {
    problems.push_back(
        {"sync.input_gpio_line", fmt::format("found {} of {}, which is the output; allowed: another line",
                                             sync.input_gpio_line, sync.input_gpio_chip)});
  }
  if (sync.output == SyncOutput::can || sync.input == SyncInput::can) {
    for (const Range& range : kUsed) {
      if (sync.can_identifier < range.first || sync.can_identifier > range.last) continue;
      problems.push_back({"sync.can_identifier",
                          fmt::format("found 0x{:03X}, which CANsync uses for {}; allowed: 0x001..0x7FF "
                                      "outside 0x010, 0x100..0x1FF, 0x300..0x3FF, 0x500..0x5FF",
                                      sync.can_identifier, range.use)});
    }
  }
  return problems;
}

}  // namespace cansyncd
