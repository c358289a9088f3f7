#include <cansync/function_blocks/layer2/can_stat.h>
#include <cansync/function_blocks/layer2/can_status.h>

#include <utility>

#include "client/src/layer2/frame_side.h"

namespace cansync::client::function_blocks {
namespace {

// Bits of EFLG (Helmholz 5.2), which says the same of a controller.
constexpr unsigned kBusOff = 0x20;
constexpr unsigned kPassive = 0x18;
constexpr unsigned kWarning = 0x01;

}  // namespace

void CAN_STAT::call() {
  detail::FrameSide& side = connection_->side();
  side.look();
  RetVal = can_status::done;
  if (PortID != 0) RetVal = can_status::wrong_port;
  if (RetVal == can_status::done && !side.daemon_present()) RetVal = can_status::refused;
  if (RetVal != can_status::done) return;
  const layer2::StatusFacts facts = side.controller();
  RxErrCtr = static_cast<BYTE>(facts.receive_errors);
  TxErrCtr = static_cast<BYTE>(facts.transmit_errors);
  const unsigned bits = layer2::error_register(facts);
  BusOff = (bits & kBusOff) != 0;
  ErrorState = (bits & kPassive) != 0;
  Warning = (bits & kWarning) != 0;
  const std::uint64_t errors = side.error_count();
  Error = std::exchange(looked_, true) && errors != errors_;
  errors_ = errors;
}

}  // namespace cansync::client::function_blocks
