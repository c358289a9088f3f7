#pragma once

#include "../slave_connection.h"
#include "types.h"

namespace cansync::client::function_blocks {

/// CANsync_BC_SL (M 4.5): receives the master's broadcast commands. A control word (command 1) is
/// CONTROLWORD_SL's, as in the registers (M 3.2.3.7), and the activation of SYNC operation the daemon's. Of
/// several that came between two calls the newest counts.
class CANSYNC_PUBLIC BC_SL {
 public:
  USINT us_BC_CMD_NR = 0;   ///< 2..255; changes with a receipt only, as the two below
  SINT si_BC_BYTE = 0;      ///< data byte
  INT i_BC_WORD = 0;        ///< data word
  SINT si_BC_RECEIVED = 0;  ///< 2: a broadcast came since the last call; else 0

  UDINT ud_RECEIPTS = 0;  ///< how many came since the last call. Not in the manual.

  /// `connection` must outlive the block. What came before does not count.
  explicit BC_SL(SlaveConnection& connection);
  /// One cycle.
  void call();

 private:
  SlaveConnection* connection_;
  std::uint64_t seen_;
};

}  // namespace cansync::client::function_blocks
