#include "daemon/cansync/requests/request_audit.h"

#include "daemon/cansync/requests/kinds.h"

namespace cansyncd {

std::string RequestAudit::before(const Request& request, cansync::State state) const {
  return with_row(request, [&](auto row, const auto& kind) { return row.before(kind, memory_, state); });
}

void RequestAudit::ended(const Requester& who, const Change& change, const Request& request,
                         cansync::State state_before, cansync::Outcome outcome, SteadyTime now) {
  const AuditTrail::End end{cansync::name(outcome), outcome == cansync::Outcome::done};
  trail_.ended(who, change, before(request, state_before), end, now);
  remember(request, outcome);
}

void RequestAudit::refused(const Requester& who, const Change& change, const Request& request,
                           cansync::State state_before, const gateway::dds::Denial& denial, SteadyTime now) {
  trail_.refused(who, change, before(request, state_before), denial, now);
}

void RequestAudit::remember(const Request& request, cansync::Outcome outcome) {
  using cansync::Outcome;
  if (outcome != Outcome::done && outcome != Outcome::no_answer) return;
  with_row(request, [&](auto row, const auto& kind) {
    if (outcome == Outcome::done) {
      row.done(kind, memory_);
    } else {
      row.perhaps_done(kind, memory_);
    }
  });
}

}  // namespace cansyncd
