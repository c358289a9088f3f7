#include <cansync/function_blocks/layer2/can_rxq.h>
#include <cansync/function_blocks/layer2/can_status.h>

#include <algorithm>

#include "client/src/layer2/frame_side.h"

namespace cansync::client::function_blocks {

void CAN_RXQ::call() {
  connection_->side().look();
  NDR = false;
  Status = take();
  Error = Status != can_status::done;
}

WORD CAN_RXQ::take() {
  detail::FrameSide& side = connection_->side();
  if (PortID != 0) return can_status::wrong_port;
  if (!side.basic().configured()) return can_status::no_queue;
  if (RxData.size() < 8) return can_status::wrong_identifier;
  const auto frame = side.basic().take();
  if (!frame) return side.daemon_present() ? can_status::done : can_status::refused;
  NDR = true;
  MsgID = frame->id;
  DLC = frame->dlc;
  std::copy_n(frame->data.begin(), frame->dlc, RxData.begin());
  return side.basic().take_overrun() ? can_status::full : can_status::done;
}

}  // namespace cansync::client::function_blocks
