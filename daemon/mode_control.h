#pragma once

#include "can/bus.h"
#include "cansync/master.h"
#include "daemon/config.h"
#include "daemon/exchange.h"

namespace cansyncd {

/// Leads the master through its states: to the start target by itself, and wherever an operator asks for.
/// Realtime thread only; realtime safe.
///
/// | mode      | from                | what happens                                             | target then
/// |
/// |-----------|---------------------|----------------------------------------------------------|---------------|
/// | set_up    | any                 | to set-up; out of active operation the values stop       | set-up | |
/// run       | set-up              | active operation, by the enable rule unless forced       | active | |
/// run       | active              | nothing                                                  | active | |
/// run       | others              | refused, `wrong_state`                                   | as it was |
/// | stop      | any                 | cold restart, then waiting for start: no SYNC            | none | |
/// reset_can | any                 | resets the controller; `wrong_state` if the bus cannot   | as it was |
/// | restart   | any                 | cold restart, then to the configured target              | as
/// configured |
class ModeControl {
 public:
  /// Both must outlive the object.
  ModeControl(cansync::Master& master, can::Bus& bus, StartTarget configured) noexcept
      : master_(master), bus_(bus), configured_(configured), target_(configured) {}

  /// Goes as far towards the target as is allowed now; call once an interval.
  void pursue_target() noexcept;

  /// Carries out an operator's request; a refusal means nothing has changed.
  cansync::Refusal request(Mode mode, bool force) noexcept;

  /// Ends operation for good: every open job ends as `master_stopped`.
  void shut_down() noexcept;

 private:
  void initialise() noexcept;
  cansync::Refusal run(bool force) noexcept;
  void set_up() noexcept;

  cansync::Master& master_;
  can::Bus& bus_;
  const StartTarget configured_;
  StartTarget target_;
};

}  // namespace cansyncd
