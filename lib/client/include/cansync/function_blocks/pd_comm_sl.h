#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>

#include "../slave_connection.h"
#include "types.h"

namespace cansync::client::function_blocks {

/// CANsync_PD_COMM_SL (M 4.22): reference values of the master in, actual values out, and actual values of
/// other slaves. Call once in each interval.
///
/// "Received" is what came since the last call. Each call with si_RDCn_SEND = 5 releases that telegram once:
/// it is sent when the master asks within u_WAIT_INTERVALS, and a newer one takes its place. When the daemon
/// was started anew nothing is released before both inputs had another value than 5 in a call; until then
/// `error` says so.
class CANSYNC_PUBLIC PD_COMM_SL {
 public:
  DINT_8_BMARRAY a_RD_VALUES_SEND = {};  ///< actual values 0..7
  SINT si_RDC1_SEND = 0;                 ///< 5: actual values 0..3 are valid; else they are not
  SINT si_RDC2_SEND = 0;                 ///< 5: actual values 4..7 are valid
  BOOL x_COPY_TO_RD_ARRAY = false;       ///< actual values of other slaves go to a_RD_ARRAY
  CANsync_RD_BMARRAY a_RD_ARRAY = {};    ///< [slave][0..7]; the own number is never entered

  DINT_8_BMARRAY a_WR_VALUES_RECEIVED = {};       ///< 0..3 change with WRC1 only, 4..7 with WRC2 only
  SINT si_WRC1_RECEIVED = 0;                      ///< 1: WRC1 came; else 0
  SINT si_WRC2_RECEIVED = 0;                      ///< 2: WRC2 came; else 0
  SINT si_RD_SL_NR1_RECEIVED = kAutomaticNumber;  ///< slave of the newest RDC1 heard; -128 none
  SINT si_RD_SL_NR2_RECEIVED = kAutomaticNumber;  ///< slave of the newest RDC2 heard; -128 none

  /// A release waits for so many intervals, 1..1000, to be asked for. 2: what comes after its interval's WRC1
  /// is good for the next one. Not in the manual.
  UINT u_WAIT_INTERVALS = 2;

  /// Why nothing is released, in words; empty without an error. Not in the manual.
  const std::string& error() const noexcept { return error_; }

  /// `connection` must outlive the block. `strength`: 0 and more; a telegram has one writer at a time,
  /// which keeps it until it gives it up, is lost, or a stronger one comes. Throws SetupError.
  explicit PD_COMM_SL(SlaveConnection& connection, std::int32_t strength = 0);
  /// Gives up what it has released.
  ~PD_COMM_SL();
  PD_COMM_SL(const PD_COMM_SL&) = delete;
  PD_COMM_SL& operator=(const PD_COMM_SL&) = delete;

  /// One cycle.
  void call();

 private:
  class Releases;

  void receive();
  bool may_release();
  void release(SINT command, std::uint8_t telegram);

  SlaveConnection* connection_;
  std::unique_ptr<Releases> releases_;
  std::array<std::uint64_t, 2> references_seen_ = {};
  std::array<std::array<std::uint64_t, 2>, 32> actuals_seen_ = {};
  std::array<std::uint64_t, 2> heard_ = {};
  std::string error_;
};

}  // namespace cansync::client::function_blocks
