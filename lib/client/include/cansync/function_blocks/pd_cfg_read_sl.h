#pragma once

#include <optional>
#include <string>

#include "../slave_connection.h"
#include "slave_command_slot.h"
#include "types.h"

namespace cansync::client::function_blocks {

/// CANsync_PD_CFG_READ_SL (M 4.17): which words of another slave's actual value telegrams belong to which
/// actual value. One for each other slave.
///
/// The mapping is given to the daemon when it differs from the one in force: once for each change of the
/// inputs, and anew after a start of the daemon. Without any number the slave is not listened to.
class CANSYNC_PUBLIC PD_CFG_READ_SL {
 public:
  SINT si_SL_NR = 0;                         ///< the other slave, 0..31
  SINT_4_BMARRAY a_RDC1 = {-1, -1, -1, -1};  ///< [word] := actual value 0..3; -1 none
  BOOL_4_BMARRAY a_HL_RDC1 = {};             ///< [word] := TRUE high word
  SINT_4_BMARRAY a_RDC2 = {-1, -1, -1, -1};  ///< [word] := actual value 4..7; -1 none
  BOOL_4_BMARRAY a_HL_RDC2 = {};

  /// The daemon has this mapping in force. Not in the manual.
  bool in_effect() const noexcept { return in_effect_; }
  /// Who refused and why, in words; empty without an error. Not in the manual.
  const std::string& error() const noexcept { return slot_.error(); }
  /// Why the daemon, or the block, refused it; none without a refusal. Not in the manual.
  RefusalCause cause() const noexcept { return slot_.cause(); }

  /// `connection` must outlive the block.
  explicit PD_CFG_READ_SL(SlaveConnection& connection) : connection_(&connection), slot_(connection) {}
  /// One cycle: enters a mapping that has changed, and takes the reply when it is there.
  void call();

 private:
  SlaveConnection* connection_;
  struct Wanted {
    int slave = 0;
    MappingBytes actual_values;
    friend bool operator==(const Wanted&, const Wanted&) = default;
  };
  bool in_effect_ = false;
  std::optional<Wanted> entered_;
  SlaveCommandSlot slot_;
};

}  // namespace cansync::client::function_blocks
