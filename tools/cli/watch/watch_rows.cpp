#include "cli/watch/watch_rows.h"

#include <algorithm>

#include "cli/base/session.h"
#include "system/clock.h"

namespace cansync::cli {

std::int64_t wall_clock() {
  return sys::read_clock(CLOCK_REALTIME).count();
}

void await_values(const client::Client& client, std::uint32_t wanted) {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::milliseconds(500);
  for (const client::SlaveStatus& status : client.slaves()) {
    if (((wanted >> status.slave) & 1u) == 0) continue;
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now());
    static_cast<void>(client.actual_values(status.slave, std::max(left, std::chrono::milliseconds(0))));
  }
}

std::vector<WatchRow> watch_rows(const client::Client& client, std::uint32_t wanted, FaultWords& faults) {
  std::vector<WatchRow> rows;
  for (const client::SlaveStatus& status : client.slaves(std::chrono::milliseconds(0))) {
    if (((wanted >> status.slave) & 1u) == 0) continue;
    WatchRow row{status, client.actual_values(status.slave, std::chrono::milliseconds(0)), 0,
                 faults.of(status)};
    if (row.values) {
      const unsigned came =
          ((row.values->ever & 1u) != 0 ? 0x0Fu : 0u) | ((row.values->ever & 2u) != 0 ? 0xF0u : 0u);
      row.shown = static_cast<std::uint8_t>(mapped_values(status.actual_mapping) & came);
    }
    rows.push_back(row);
  }
  return rows;
}

std::int64_t raw_number(const client::ActualValues& values, unsigned value, bool is_signed) {
  // The sample knows its own width; what the status says follows the mapping a little later.
  const bool word = ((values.words >> value) & 1u) != 0;
  return raw_number(values.raw[value], {word ? Width::word : Width::doubleword, is_signed});
}

}  // namespace cansync::cli
