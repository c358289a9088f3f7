#pragma once

#include <optional>

#include "setting_slot.h"
#include "types.h"

namespace cansync::client::function_blocks {

/// CANsync_PD_CFG_MA (M 4.15): which word of which reference value stands where in the reference value
/// telegrams. The mapping is sent when it differs from the one sent last, and when the daemon was started
/// anew, not in every call.
class CANSYNC_PUBLIC PD_CFG_MA {
 public:
  SINT_4_BMARRAY a_WRC1 = {-1, -1, -1, -1};  ///< [word] := reference value 0..3; -1 none
  BOOL_4_BMARRAY a_HL_WRC1 = {};             ///< [word] := TRUE high word
  SINT_4_BMARRAY a_WRC2 = {-1, -1, -1, -1};  ///< [word] := reference value 4..7; -1 none
  BOOL_4_BMARRAY a_HL_WRC2 = {};

  /// The mapping is in effect in the daemon. Not in the manual.
  bool in_effect() const noexcept { return slot_.sent(); }
  /// Who refused and why, in words; empty without an error. Not in the manual.
  const std::string& error() const noexcept { return slot_.error(); }
  /// Why the daemon, or the block, refused it; none without a refusal. Not in the manual.
  RefusalCause cause() const noexcept { return slot_.cause(); }

  /// `client` must outlive the block, and counts its mapping among the settings that PD_COMM_MA waits for.
  explicit PD_CFG_MA(Client& client) : slot_(client, "PD_CFG_MA") {}
  /// One cycle: enters a mapping that has changed, and takes the reply when it is there. A number that is not
  /// -1..7 is refused here (`error`); one of the other telegram by the daemon.
  void call();

 private:
  struct Inputs {
    SINT_4_BMARRAY one, two;
    BOOL_4_BMARRAY high_one, high_two;
    friend bool operator==(const Inputs&, const Inputs&) = default;
  };
  std::optional<Inputs> entered_;
  SettingSlot slot_;
};

}  // namespace cansync::client::function_blocks
