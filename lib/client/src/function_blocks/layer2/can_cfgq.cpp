#include <cansync/function_blocks/layer2/can_cfgq.h>
#include <cansync/function_blocks/layer2/can_status.h>
#include <fmt/format.h>

#include <utility>

#include "client/src/function_blocks/layer2/saia_checks.h"
#include "client/src/layer2/frame_side.h"

namespace cansync::client::function_blocks {

void CAN_CFGQ::call() {
  connection_->side().look();
  error_.clear();
  RetVal = configure();
}

WORD CAN_CFGQ::configure() {
  detail::FrameSide& side = connection_->side();
  if (PortID != 0) return refuse(can_status::wrong_port, kOnlyPort);
  for (const auto& [enabled, routine] : {std::pair{RxEnableInt, RxIntOB}, std::pair{TxEnableInt, TxIntOB}})
    if (enabled && !is_routine(routine))
      return refuse(can_status::wrong_parameter,
                    fmt::format("client: RxIntOB, TxIntOB {}: allowed 40..47 when enabled", routine));
  for (const INT depth : {RxQueueDepth, TxQueueDepth}) {
    if (depth < 1)
      return refuse(can_status::wrong_parameter,
                    fmt::format("client: RxQueueDepth, TxQueueDepth {}: allowed 1..{}", depth, kDeepest));
    if (depth > kDeepest)
      return refuse(can_status::no_memory,
                    fmt::format("client: RxQueueDepth, TxQueueDepth {}: allowed 1..{}", depth, kDeepest));
  }
  const DWORD largest = IDE ? can::kExtendedIdentifierMask : can::kStandardIdentifierMask;
  if (MsgID > largest)
    return refuse(can_status::wrong_parameter,
                  fmt::format("client: MsgID 0x{:X}: allowed 0..0x{:X}", MsgID, largest));
  if (!side.daemon_present()) return refuse(can_status::refused, "client: no daemon serves the bus");
  if (!side.begun()) return refuse(can_status::refused, "client: call CAN_CFG first");
  side.basic().configure({.identifier = MsgID,
                          .mask = Mask & largest,
                          .extended = IDE,
                          .receive_depth = static_cast<std::size_t>(RxQueueDepth),
                          .send_depth = static_cast<std::size_t>(TxQueueDepth),
                          .received = {RxIntOB, RxIntPrm, RxEnableInt},
                          .sent_empty = {TxIntOB, TxIntPrm, TxEnableInt}});
  return can_status::done;
}

WORD CAN_CFGQ::refuse(WORD code, std::string reason) {
  error_ = std::move(reason);
  return code;
}

}  // namespace cansync::client::function_blocks
