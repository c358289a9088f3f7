#pragma once

#include <optional>

#include "setting_slot.h"
#include "types.h"

namespace cansync::client::function_blocks {

/// CANsync_COMM_CONTROL_MA (M 4.6): which slave the command channel serves, for each kind of job.
///
/// A setting is sent when it differs from the one sent last, and when the daemon was started anew, not in
/// every call. Parameter jobs, control words that enable and transfers of a slave that no cursor names wait
/// and end when their monitoring time is over; control words that stop wait for no cursor.
class CANSYNC_PUBLIC COMM_CONTROL_MA {
 public:
  SINT si_SL_NR_CTRL = kAutomaticNumber;  ///< control words that enable: -128 automatic, 0..31
  BOOL x_EN_CTRL = false;                 ///< si_SL_NR_CTRL counts
  SINT si_SL_NR_PAR = kAutomaticNumber;   ///< parameters
  BOOL x_EN_PAR = false;
  SINT si_SL_NR_UDL = kAutomaticNumber;  ///< uploads and downloads
  BOOL x_EN_UDL = false;
  SINT si_MAX_SL_NR = -1;  ///< automatic numbers rise up to it, 0..31; -1 unchanged

  /// The setting is in effect in the daemon. Not in the manual.
  bool in_effect() const noexcept { return cursors_slot_.sent() && (!maximum_ || maximum_slot_.sent()); }
  /// Who refused and why, in words; empty without an error. Not in the manual.
  const std::string& error() const noexcept {
    return cursors_slot_.refused() ? cursors_slot_.error() : maximum_slot_.error();
  }
  /// Why the daemon, or the block, refused it; none without a refusal. Not in the manual.
  RefusalCause cause() const noexcept {
    return cursors_slot_.refused() ? cursors_slot_.cause() : maximum_slot_.cause();
  }

  /// `client` must outlive the block, and counts its settings among those that PD_COMM_MA waits for.
  explicit COMM_CONTROL_MA(Client& client)
      : cursors_slot_(client, "COMM_CONTROL_MA"), maximum_slot_(client, "COMM_CONTROL_MA") {}
  /// One cycle: enters what has changed, and takes replies that are there. A negative number that means
  /// nothing is refused here (`error`), one over 31 by the daemon.
  void call();

 private:
  std::optional<std::array<std::int32_t, 3>> cursors_;  ///< entered last
  std::optional<SINT> maximum_;
  SettingSlot cursors_slot_;
  SettingSlot maximum_slot_;
};

}  // namespace cansync::client::function_blocks
