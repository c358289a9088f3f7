#include "daemon/segment/segment.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace cansyncd {

std::string not_taken(const ReloadPlan& plan) {
  if (plan.problems.empty())
    return fmt::format("not changed before a restart: {}", fmt::join(plan.needs_restart, ", "));
  const config::Problem& first = plan.problems.front();
  return fmt::format("nothing is changed: {}{}{}", first.key, first.key.empty() ? "" : ": ", first.text);
}

}  // namespace cansyncd
