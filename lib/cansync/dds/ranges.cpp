#include "cansync/dds/ranges.h"

#include <fmt/format.h>

namespace cansync::dds {

using gateway::dds::Denial;

Problem in_range(std::string_view field, std::int64_t value, std::int64_t minimum, std::int64_t maximum) {
  if (value >= minimum && value <= maximum) return std::nullopt;
  return Denial{gateway_CAUSE_FIELD,
                fmt::format("{} {}: out of range; allowed {}..{}", field, value, minimum, maximum)};
}

std::string list_of(SlaveMask slaves) {
  std::string list;
  const auto has = [&](unsigned slave) { return slave < kSlaves && ((slaves.bits >> slave) & 1u) != 0; };
  for (unsigned slave = 0; slave < kSlaves; ++slave) {
    if (!has(slave)) continue;
    unsigned last = slave;
    while (has(last + 1)) ++last;
    if (!list.empty()) list += ", ";
    list += last == slave ? fmt::format("{}", slave) : fmt::format("{}..{}", slave, last);
    slave = last;
  }
  return list.empty() ? "none" : list;
}

Problem configured_slave(std::string_view field, std::uint32_t slave, const Limits& limits) {
  if (Problem problem = in_range(field, slave, 0, SlaveNumber::max)) return problem;
  if (((limits.configured.bits >> slave) & 1u) != 0) return std::nullopt;
  return Denial{gateway_CAUSE_SLAVE_NOT_CONFIGURED,
                fmt::format("{} {}: not configured; allowed {}", field, slave, list_of(limits.configured))};
}

Problem timeout_in_range(std::uint32_t timeout) {
  if (timeout <= kMaximumTimeoutMs) return std::nullopt;
  return Denial{gateway_CAUSE_FIELD,
                fmt::format("timeout {} ms: out of range; allowed 0..{} ms, 0 = the daemon's default",
                            timeout, kMaximumTimeoutMs)};
}

}  // namespace cansync::dds
