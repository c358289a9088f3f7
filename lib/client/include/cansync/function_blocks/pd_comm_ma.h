#pragma once

#include <optional>

#include "actual_value_inbox.h"
#include "setting_slot.h"
#include "types.h"

namespace cansync::client::function_blocks {

/// CANsync_PD_COMM_MA (M 4.19): gives the reference values and takes the actual values of every slave.
///
/// Over DDS values are not taken in the very interval in which the block is called: reference values are
/// released once, in the next interval after they have arrived in the daemon; what was received is what came
/// since the last call, and the slave numbers show the newest; the first telegram of each slave is not told,
/// because it may be an old one that the daemon kept. A program that has to hit an interval uses
/// ReferenceWriter::write with `from_interval`. Call it not more often than once an interval: the
/// daemon refuses values when too many wait. Which slave is asked is sent when it changes, and when the
/// daemon was started anew.
///
/// Values are given only while every setting that blocks of this client have entered (PD_CFG_MA,
/// PD_CFG_READ_MA, COMM_CONTROL_MA, and the polling of this block) is in effect; until then `error` names the
/// one that is not. After the daemon was started anew, or another program has changed the mapping of the
/// reference values, none is given until both inputs si_WRCx_SEND had another value than 5 in a call; `error`
/// says so.
class CANSYNC_PUBLIC PD_COMM_MA {
 public:
  CANsync_RD_BMARRAY a_RD_ARRAY = {};    ///< values 0..7 of each slave are filled, 8..15 stay
  DINT_8_BMARRAY a_WR_VALUES_SEND = {};  ///< 0..3 go with telegram 1, 4..7 with telegram 2
  SINT si_WRC1_SEND = 0;                 ///< 5: values 0..3 are valid; any other: they are not
  SINT si_WRC2_SEND = 0;                 ///< 5: values 4..7 are valid
  SINT si_RD_SL_NR1_RECEIVE =
      kAutomaticNumber;  ///< slave asked for telegram 1: 0..31, -128 automatic, -1 nobody
  SINT si_RD_SL_NR2_RECEIVE = kAutomaticNumber;  ///< slave asked for telegram 2
  SINT si_MAX_SL_NR = -1;                        ///< automatic numbers rise up to it, 0..31; -1 unchanged
  BOOL x_COPY_TO_RD_ARRAY = false;               ///< actual values are entered in a_RD_ARRAY

  SINT si_RD_SL_NR1_RECEIVED =
      kAutomaticNumber;  ///< whose telegram 1 came last since the last call; -128 none
  SINT si_RD_SL_NR2_RECEIVED = kAutomaticNumber;  ///< likewise of telegram 2

  /// Who refused and why, in words; empty without an error. Not in the manual. Bad reference values are
  /// reported by the daemon as an event.
  const std::string& error() const noexcept { return error_; }

  /// `strength`: of the writer of reference values, see ReferenceWriter. Waits at most 2 s for the daemon;
  /// throws NoDaemon, SetupError.
  explicit PD_COMM_MA(Client& client, std::int32_t strength = 0)
      : inbox_(client),
        writer_(client, strength),
        client_(&client),
        slot_(client, "PD_COMM_MA"),
        meant_for_(client.validity()) {}
  /// One cycle: gives the values whose input is 5, asks, and takes what came since the last call. `error`
  /// says what was not given.
  void call();

 private:
  bool may_give();
  void give(SINT command, std::uint8_t telegram);
  void ask();

  ActualValueInbox inbox_;
  ReferenceWriter writer_;
  Client* client_;
  SettingSlot slot_;
  Validity meant_for_;   ///< the daemon that values are given to
  bool locked_ = false;  ///< nothing is given until neither input is 5
  std::optional<std::array<SINT, 3>> asked_;
  std::string error_;
};

}  // namespace cansync::client::function_blocks
