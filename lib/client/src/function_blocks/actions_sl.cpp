#include <cansync/function_blocks/bc_sl.h>
#include <cansync/function_blocks/controlword_sl.h>

#include <utility>

#include "client/src/cansync_slave/slave_side.h"

namespace cansync::client::function_blocks {
namespace {

constexpr SINT kReceipt = 2;  // M 3.2.3.7

/// How many came since the last look.
UDINT receipts(const detail::SlaveSide::Action& action, std::uint64_t& seen) {
  return static_cast<UDINT>(action.count - std::exchange(seen, action.count));
}

}  // namespace

BC_SL::BC_SL(SlaveConnection& connection) : connection_(&connection) {
  connection.side().look();
  seen_ = connection.side().broadcast().count;
}

void BC_SL::call() {
  connection_->side().look();
  const detail::SlaveSide::Action& action = connection_->side().broadcast();
  ud_RECEIPTS = receipts(action, seen_);
  si_BC_RECEIVED = ud_RECEIPTS != 0 ? kReceipt : SINT{0};
  if (ud_RECEIPTS == 0) return;
  us_BC_CMD_NR = action.command;
  si_BC_BYTE = static_cast<SINT>(action.data_byte);
  i_BC_WORD = static_cast<INT>(action.data_word);
}

CONTROLWORD_SL::CONTROLWORD_SL(SlaveConnection& connection) : connection_(&connection) {
  connection.side().look();
  seen_ = connection.side().control_word().count;
}

void CONTROLWORD_SL::call() {
  connection_->side().look();
  const detail::SlaveSide::Action& action = connection_->side().control_word();
  ud_RECEIPTS = receipts(action, seen_);
  si_RECEIVED = ud_RECEIPTS != 0 ? kReceipt : SINT{0};
  if (ud_RECEIPTS != 0) w_CONTROLWORD = action.data_word;
}

}  // namespace cansync::client::function_blocks
