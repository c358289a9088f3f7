#pragma once

#include "cansync/cluster/lead_axis.h"
#include "cansync/master.h"
#include "daemon/cansync/exchange.h"
#include "daemon/cansync/realtime/mode_control.h"
#include "daemon/cansync/realtime/reporter.h"

namespace cansyncd {

/// Takes the gateway's requests to the master. Realtime thread only; realtime safe.
class RequestIntake {
 public:
  /// All must outlive the object. `lead`: what it gives nobody else may; null: there is none.
  RequestIntake(Exchange& exchange, cansync::Master& master, ModeControl& mode, Reporter& reporter,
                const cansync::LeadAxis* lead = nullptr) noexcept
      : exchange_(exchange), master_(master), mode_(mode), reporter_(reporter), lead_(lead) {}

  /// Takes at most `most` waiting requests, and only while the answer of each has room.
  void take(unsigned most) noexcept;

  /// Answers a reset of the controller that has ended, or has taken longer than 5 s; once an interval.
  void finish_reset() noexcept;

  /// Answers every waiting request, and a reset that is under way, as `master_stopped`, as far as there is
  /// room.
  void refuse_all_as_stopped() noexcept;

  /// Publishes the settings in force.
  void publish_settings() noexcept;

 private:
  // One function a request type; the variant's type picks it.
  template <class Job>
  void handle(const Job& job) noexcept;
  void handle(const cansync::ReferenceUpdate& update) noexcept;
  void handle(const Cancel& cancel) noexcept;
  void handle(const StopRelease& stop) noexcept;
  void handle(const ModeRequest& request) noexcept;
  void handle(const SetPolling& request) noexcept;
  void handle(const SetCursors& request) noexcept;
  void handle(const SetReferenceMapping& request) noexcept;
  void handle(const SetActualMapping& request) noexcept;
  void handle(const SetReferenceLimits& request) noexcept;
  void handle(const ReleaseSlave& request) noexcept;
  void answer(cansync::JobId id, cansync::Refusal refusal) noexcept;
  void answer_setting(cansync::JobId id, cansync::Refusal refusal) noexcept;

  Exchange& exchange_;
  cansync::Master& master_;
  ModeControl& mode_;
  Reporter& reporter_;
  const cansync::LeadAxis* const lead_;
  cansync::JobId reset_ = 0;  ///< request of the reset that is under way
  can::Time reset_begun_{};
};

}  // namespace cansyncd
