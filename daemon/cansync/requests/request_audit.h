#pragma once

#include <optional>
#include <string>

#include "daemon/cansync/exchange.h"
#include "daemon/cansync/requests/audit_memory.h"
#include "daemon/desk/audit.h"

namespace cansyncd {

/// The audit trail of requests of CANsync, with what their values were before. Gateway thread only.
class RequestAudit {
 public:
  /// `trail` must outlive the object.
  RequestAudit(AuditTrail& trail, const Config& config) : trail_(trail), memory_(config) {}

  /// The value `request` would replace, or "not known". `state`: the master's, when the request was taken.
  std::string before(const Request& request, cansync::State state) const;

  /// A request ended as `outcome`: its entry.
  void ended(const Requester& who, const Change& change, const Request& request, cansync::State state_before,
             cansync::Outcome outcome, SteadyTime now);

  /// A request was refused: its entry.
  void refused(const Requester& who, const Change& change, const Request& request,
               cansync::State state_before, const gateway::dds::Denial& denial, SteadyTime now);

  /// `request` ended as `outcome`: keeps what it has set, or forgets what it may have changed.
  void remember(const Request& request, cansync::Outcome outcome);
  /// A parameter job ended.
  void learn(const cansync::ParameterRequest& request, const cansync::ParameterResult& result) {
    memory_.learn(request, result);
  }

 private:
  AuditTrail& trail_;
  AuditMemory memory_;
};

}  // namespace cansyncd
