#include <cansync/function_blocks/layer2/can_status.h>
#include <cansync/function_blocks/layer2/can_txq.h>
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "client/src/function_blocks/layer2/saia_checks.h"
#include "client/src/layer2/frame_side.h"
#include "text/counts.h"

namespace cansync::client::function_blocks {

void CAN_TXQ::call() {
  detail::FrameSide& side = connection_->side();
  side.look();
  Status = enter();
  Error = Status != can_status::done;
  side.look();
  if (!Error) error_ = side.failure();
}

WORD CAN_TXQ::enter() {
  detail::FrameSide& side = connection_->side();
  if (PortID != 0) return refuse(can_status::wrong_port, kOnlyPort);
  if (!side.basic().configured()) return refuse(can_status::no_queue, "client: call CAN_CFGQ first");
  if (DLC < 0 || DLC > 8 || TxData.size() < static_cast<std::size_t>(DLC))
    return refuse(can_status::wrong_length,
                  fmt::format("client: DLC {}: allowed 0..8, and TxData as long at least; it has {}", DLC,
                              text::counted(TxData.size(), "byte")));
  can::Frame frame;
  frame.extended = side.basic().settings().extended;
  frame.id = MsgID;
  frame.dlc = static_cast<std::uint8_t>(DLC);
  std::copy_n(TxData.begin(), DLC, frame.data.begin());
  if (frame.id != frame.identifier())
    return refuse(can_status::refused,
                  fmt::format("client: MsgID 0x{:X}: allowed 0..0x{:X}", MsgID,
                              frame.extended ? can::kExtendedIdentifierMask : can::kStandardIdentifierMask));
  if (side.take_restart())
    return refuse(
        can_status::refused,
        "client: the daemon was started anew: this frame was not sent; call again if it still holds");
  if (std::string obstacle = side.obstacle(); !obstacle.empty())
    return refuse(can_status::refused, std::move(obstacle));
  if (!side.basic().send({.frame = frame, .by_identifier = Priority}))
    return refuse(can_status::full, "client: the send queue is full; call again when a frame has left it");
  return can_status::done;
}

WORD CAN_TXQ::refuse(WORD code, std::string reason) {
  error_ = std::move(reason);
  return code;
}

}  // namespace cansync::client::function_blocks
