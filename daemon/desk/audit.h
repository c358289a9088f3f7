#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "daemon/cansync/requests/audit_memory.h"
#include "daemon/cansync/requests/audit_text.h"
#include "daemon/desk/gateway_events.h"
#include "daemon/service/journal.h"

namespace cansyncd {

/// Who gave a request.
struct Requester {
  std::string name;         ///< what the client calls itself
  std::string label;        ///< the same with the beginning of its identity, for people
  std::string participant;  ///< DDS participant, 32 hexadecimal digits; empty: not known. With DDS Security
                            ///< its first 12 come from the certificate and cannot be chosen
  std::uint64_t request = 0;
};

/// Records every request that would change a drive, the line or the master: who, what, old and new value,
/// result; one entry in the journal for each, and an event. Gateway thread only.
///
/// What is accepted is bounded by the bus (one telegram an interval), so each has its entry. Of what is
/// refused at most `kRefused` a second have one, the rest is counted and told in one entry a second, because
/// a client can send without limit.
class AuditTrail {
 public:
  static constexpr unsigned kRefused = 100;

  /// All must outlive the object.
  AuditTrail(JournalSink& journal, EventPublisher& events, const Config& config)
      : journal_(journal), events_(events), memory_(config), bus_(config.bus.name) {}

  /// A request that had been accepted ended as `outcome`. `change` empty: it asked for no change.
  void ended(const Requester& who, const std::optional<Change>& change, const Request& request,
             cansync::State state_before, cansync::Outcome outcome, SteadyTime now);

  /// A request was refused for `reason`; `request`: as far as it was understood.
  void refused(const Requester& who, const std::optional<Change>& change, const Request* request,
               cansync::State state_before, const std::string& reason, SteadyTime now);

  /// A parameter was read or written; call it after `ended`.
  void learn(const cansync::ParameterRequest& request, const cansync::ParameterResult& result) {
    memory_.learn(request, result);
  }

  /// Tells what was counted. Returns when to call again; nothing: no need.
  std::optional<SteadyTime> tick(SteadyTime now);

 private:
  struct Entry {
    const Requester& who;
    const Change& change;
    std::string before;
    std::string result;
    EventCode code;
  };
  void write(const Entry& entry, SteadyTime now);
  bool may_record_refusal(SteadyTime now);

  JournalSink& journal_;
  EventPublisher& events_;
  AuditMemory memory_;
  std::string bus_;
  SteadyTime window_;
  unsigned recorded_ = 0;  ///< refusals of this window
  std::uint64_t not_recorded_ = 0;
};

}  // namespace cansyncd
