#pragma once

#include <optional>
#include <string>

#include "../slave_connection.h"
#include "slave_command_slot.h"
#include "types.h"

namespace cansync::client::function_blocks {

/// CANsync_PD_CFG_SL (M 4.18): which words of the reference value telegrams belong to which reference value,
/// and which words of which actual value stand where in this slave's actual value telegrams.
///
/// The mapping is given to the daemon when it differs from the one in force: once for each change of the
/// inputs, and anew after a start of the daemon. It is in force with the next interval at the latest. As the
/// manual says, nobody compares it with the master's.
class CANSYNC_PUBLIC PD_CFG_SL {
 public:
  SINT_4_BMARRAY a_WRC1 = {-1, -1, -1, -1};  ///< [word] := reference value 0..3; -1 none
  BOOL_4_BMARRAY a_HL_WRC1 = {};             ///< [word] := TRUE high word
  SINT_4_BMARRAY a_WRC2 = {-1, -1, -1, -1};  ///< [word] := reference value 4..7; -1 none
  BOOL_4_BMARRAY a_HL_WRC2 = {};
  SINT_4_BMARRAY a_RDC1 = {-1, -1, -1, -1};  ///< [word] := actual value 0..3; -1 none
  BOOL_4_BMARRAY a_HL_RDC1 = {};
  SINT_4_BMARRAY a_RDC2 = {-1, -1, -1, -1};  ///< [word] := actual value 4..7; -1 none
  BOOL_4_BMARRAY a_HL_RDC2 = {};

  /// The daemon has this mapping in force. Not in the manual.
  bool in_effect() const noexcept { return in_effect_; }
  /// Who refused and why, in words; empty without an error. Not in the manual.
  const std::string& error() const noexcept { return slot_.error(); }
  /// Why the daemon, or the block, refused it; none without a refusal. Not in the manual.
  RefusalCause cause() const noexcept { return slot_.cause(); }

  /// `connection` must outlive the block.
  explicit PD_CFG_SL(SlaveConnection& connection) : connection_(&connection), slot_(connection) {}
  /// One cycle: enters a mapping that has changed, and takes the reply when it is there.
  void call();

 private:
  SlaveConnection* connection_;
  struct Wanted {
    MappingBytes references, actual_values;
    friend bool operator==(const Wanted&, const Wanted&) = default;
  };
  bool in_effect_ = false;
  std::optional<Wanted> entered_;
  SlaveCommandSlot slot_;
};

}  // namespace cansync::client::function_blocks
