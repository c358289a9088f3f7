#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "cansync/channel/jobs.h"
#include "cansync/config/config.h"
#include "cansync/telegram/numbers.h"
#include "daemon/cansync/exchange.h"
#include "daemon/cansync/requests/request_audit.h"
#include "daemon/cansync/texts/refusal_text.h"
#include "daemon/desk/gateway_events.h"

namespace cansyncd {

/// Sends the control word of the failsafe reaction to its slaves through the command channel, and tells how
/// that ended: one event when it begins, one when every slave's outcome is known, and each control word in
/// the audit trail. Does nothing unless that is the configured reaction. Gateway thread only.
class FailsafeCommands {
 public:
  /// `events` and `audit` must outlive this object.
  FailsafeCommands(EventPublisher& events, RequestAudit& audit, const Config& config);

  /// The slaves it sends its control word to; none unless that is the configured reaction.
  cansync::SlaveMask slaves() const noexcept { return slaves_; }

  /// Values of a telegram (0 or 1) are missing: begins a round. One that runs ends, because a slave that has
  /// had its word may have got another one since; nothing happens when none of its words has been handed on.
  void start(unsigned channel, const Config& config, SteadyTime now);

  /// New values of the telegram came. When those of no other one are missing, words that were not sent yet
  /// are withdrawn.
  void values_back(unsigned channel, const Config& config, SteadyTime now);

  /// Hands on what there was no room for. Returns when to call again; nothing: no need.
  std::optional<SteadyTime> push(Exchange& exchange, SteadyTime now);

  /// Takes the answer to one of these control words; false: it belongs to somebody else.
  bool finish(const Terminal& terminal, const Config& config, const RefusalContext& line, SteadyTime now);

 private:
  cansync::JobId id_of(cansync::SlaveNumber slave, std::uint64_t round) const noexcept;
  cansync::ControlWordRequest request_to(cansync::SlaveNumber slave) const;
  void end(const Config& config, SteadyTime now);

  EventPublisher& events_;
  RequestAudit& audit_;
  std::optional<std::uint16_t> word_;  ///< nothing: another reaction is configured
  cansync::SlaveMask slaves_;
  std::array<bool, cansync::kChannels> missing_ = {};  ///< values of these telegrams
  std::uint64_t round_ = 0;
  cansync::SlaveMask waiting_;    ///< not handed on yet
  cansync::SlaveMask open_;       ///< no outcome yet
  cansync::SlaveMask to_cancel_;  ///< handed on, and to be withdrawn
  cansync::SlaveMask sent_;
  cansync::SlaveMask withdrawn_;
  std::string failed_;  ///< outcomes of the slaves that did not get it
};

}  // namespace cansyncd
