#include "daemon/segment/segment.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace cansyncd {

std::string not_taken(const ReloadPlan& plan) {
  if (plan.problems.empty()) {
    std::vector<std::string> keys = plan.needs_restart;
    keys.insert(keys.end(), plan.needs_set_up.begin(), plan.needs_set_up.end());
    return fmt::format(
        "not changed before {}: {}",
        plan.needs_restart.empty() ? "the line is set up anew (mode stop, then a reload)" : "a restart",
        fmt::join(keys, ", "));
  }
  const config::Problem& first = plan.problems.front();
  return fmt::format("nothing is changed: {}{}{}", first.key, first.key.empty() ? "" : ": ", first.text);
}

void Segment::tell_reload(const ReloadPlan& plan) {
  if (!plan.problems.empty()) {
    post({gateway_SEVERITY_ERROR, "reload_refused", -1, not_taken(plan), {}});
  } else if (!plan.needs_restart.empty() || !plan.needs_set_up.empty()) {
    post({gateway_SEVERITY_WARNING, "setting_needs_restart", -1, not_taken(plan), {}});
  }
}

void Segment::tell_inhibitors(const InhibitorState& before, const InhibitorState& now) {
  if (!now.refused.empty() && now.refused != before.refused) {
    post({gateway_SEVERITY_WARNING,
          "sleep_not_inhibited",
          -1,
          "this computer may sleep or be switched off while the line is in run: logind refuses the locks: " +
              now.refused,
          {}});
  } else if (now.held && !before.refused.empty()) {
    post({gateway_SEVERITY_INFO,
          "sleep_inhibited",
          -1,
          "logind keeps this computer from sleeping while the line is in run",
          {}});
  }
}

}  // namespace cansyncd
