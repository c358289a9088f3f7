#pragma once

#include <optional>

#include "setting_slot.h"
#include "types.h"

namespace cansync::client::function_blocks {

/// CANsync_PD_CFG_READ_MA (M 4.16): which actual value the words of a slave's actual value telegrams belong
/// to. The mapping is sent when it differs from the one sent last, and when the daemon was started anew, not
/// in every call.
class CANSYNC_PUBLIC PD_CFG_READ_MA {
 public:
  SINT si_SL_NR = 0;                         ///< 0..31
  SINT_4_BMARRAY a_RDC1 = {-1, -1, -1, -1};  ///< [word] := actual value 0..3; -1 none
  BOOL_4_BMARRAY a_HL_RDC1 = {};             ///< [word] := TRUE high word
  SINT_4_BMARRAY a_RDC2 = {-1, -1, -1, -1};  ///< [word] := actual value 4..7; -1 none
  BOOL_4_BMARRAY a_HL_RDC2 = {};

  /// The mapping is in effect in the daemon. Not in the manual.
  bool in_effect() const noexcept { return slot_.sent(); }
  /// Who refused and why, in words; empty without an error. Not in the manual.
  const std::string& error() const noexcept { return slot_.error(); }
  /// Why the daemon, or the block, refused it; none without a refusal. Not in the manual.
  RefusalCause cause() const noexcept { return slot_.cause(); }

  /// `client` must outlive the block, and counts its mapping among the settings that PD_COMM_MA waits for.
  explicit PD_CFG_READ_MA(Client& client) : client_(&client), slot_(client, "PD_CFG_READ_MA") {}
  /// One cycle: enters a mapping that has changed, and takes the reply when it is there. A slave or number
  /// out of range is refused here (`error`).
  void call();

 private:
  struct Inputs {
    SINT slave;
    SINT_4_BMARRAY one, two;
    BOOL_4_BMARRAY high_one, high_two;
    friend bool operator==(const Inputs&, const Inputs&) = default;
  };
  Client* client_;
  std::optional<Inputs> entered_;
  SettingSlot slot_;
};

}  // namespace cansync::client::function_blocks
