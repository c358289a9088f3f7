#pragma once

#include <optional>

#include "can/bus.h"
#include "cansync/cluster/cluster.h"
#include "cansync/config/config.h"
#include "cansync/master.h"
#include "daemon/cansync/exchange.h"

namespace cansyncd {

/// Leads the master through its states: to the start target by itself, and wherever an operator asks for.
/// Realtime thread only; realtime safe.
///
/// | mode      | from    | what happens                                       | target then   |
/// |-----------|---------|----------------------------------------------------|---------------|
/// | set_up    | any     | to set-up; out of active operation the values stop | set-up        |
/// | run       | set-up  | active operation, by the enable rule unless forced | active        |
/// | run       | active  | nothing                                            | active        |
/// | run       | others  | refused, `wrong_state`                             | as it was     |
/// | stop      | any     | cold restart, then waiting for start: no SYNC      | none          |
/// | reset_can | any     | resets the controller, or says why it cannot       | as it was     |
/// | restart   | any     | cold restart, then to the configured target        | as configured |
///
/// In a cluster SYNC begins when the upper bus's is followed; what wants it waits for that. It waits as well
/// until the master has listened, and while another master sends; with `AfterOtherMaster::command` the target
/// is none from then on. `set_up` is refused, `other_master`, while another master sends, unless forced.
class ModeControl {
 public:
  /// All must outlive the object. `cluster`: that the master is of; null: of none.
  ModeControl(cansync::Master& master, can::Bus& bus, StartTarget configured, StartTarget first,
              AfterOtherMaster after_other_master = AfterOtherMaster::resume,
              const cansync::Cluster* cluster = nullptr) noexcept
      : master_(master),
        bus_(bus),
        configured_(configured),
        after_other_master_(after_other_master),
        cluster_(cluster),
        target_(first) {}

  /// Where it is going.
  StartTarget target() const noexcept { return target_; }

  /// It waits for a command, because another master was on the bus.
  bool waits_for_command() const noexcept { return waits_for_command_; }

  /// The upper bus of the cluster, if there is one, has SYNC that is followed.
  bool sync_allowed() const noexcept { return cluster_ == nullptr || cluster_->sync_allowed(); }

  /// Goes as far towards the target as is allowed now; call once an interval.
  void pursue_target() noexcept;

  /// Carries out an operator's request; a refusal means nothing has changed.
  /// `Mode::reset_can` may take its time: `reset_pending` is true then, and `finish_reset` tells the end.
  cansync::Refusal request(Mode mode, bool force) noexcept;

  /// A reset of the controller is under way.
  bool reset_pending() const noexcept { return reset_pending_; }

  /// Waits for it no longer.
  void forget_reset() noexcept { reset_pending_ = false; }

  /// The outcome of that reset; nothing while it is under way.
  std::optional<cansync::Refusal> finish_reset() noexcept;

  /// Ends operation for good: every open job ends as `master_stopped`.
  void shut_down() noexcept;

 private:
  void initialise() noexcept;
  cansync::Refusal run(bool force) noexcept;
  cansync::Refusal end_reset(can::ResetResult result) noexcept;
  cansync::Refusal set_up(bool force) noexcept;
  void wait_for_command() noexcept;

  cansync::Master& master_;
  can::Bus& bus_;
  const StartTarget configured_;
  const AfterOtherMaster after_other_master_;
  const cansync::Cluster* const cluster_;
  StartTarget target_;
  bool waits_for_command_ = false;
  bool reset_pending_ = false;
};

}  // namespace cansyncd
