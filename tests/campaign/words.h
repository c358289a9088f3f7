#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/cansync/requests/request_audit.h"
#include "daemon/cansync/requests/topics.h"
#include "daemon/desk/audit.h"
#include "plan.h"

namespace cansyncd::campaign {

/// An entry of the journal.
struct JournalEntry {
  std::string event;  ///< word
  std::vector<JournalField> fields;
  /// Empty when there is no such field.
  std::string_view field(std::string_view name) const;
};

/// How a request ended, in everything that is said of it to people and programs.
struct Said {
  gateway_ReplyCode code = gateway_REPLY_DONE;  ///< of the reply
  gateway_RefusalCause cause = gateway_CAUSE_NONE;
  std::string reason;
  unsigned exit_status = 0;  ///< of `cansync`
  std::vector<JournalEntry> entries;
  std::vector<EventText> events;  ///< with a record of the request
};

/// Says it with the functions of the gateway and of `cansync`, in the order of the gateway's desk
/// (daemon/desk/job_desk_answers.h).
class Words final : private JournalSink, private EventSink {
 public:
  /// `plan` and `exchange` must outlive the object.
  Words(const Plan& plan, Exchange& exchange);

  /// `request` has ended so, when the line was in `state`. `remembers`: the audit trail learns from it.
  Said ended(const Request& request, const Terminal& terminal, cansync::State state, bool remembers,
             SteadyTime now);

  /// Refused requests that are told in a sum alone, so far, counted by what the journal says. Call it after the
  /// last request, with a time that is later by more than a second.
  std::uint64_t summed_up(SteadyTime now);

 private:
  void write(LogPriority priority, EventCode event, const std::string& message,
             const std::vector<JournalField>& fields) override;
  bool publish(const EventText& event, SteadyTime now) override;
  void record(const Request& request, const Terminal& terminal, const JobContext& context, bool remembers);
  void reply(const Request& request, const Terminal& terminal, const JobContext& context);

  Exchange& exchange_;
  Config config_;
  AuditTrail trail_;
  RequestAudit audit_;
  Said said_;
  std::uint64_t summed_up_ = 0;
};

}  // namespace cansyncd::campaign
