#include <cansync/function_blocks/layer2/can_rx.h>
#include <cansync/function_blocks/layer2/can_status.h>

#include <algorithm>
#include <utility>

#include "client/src/function_blocks/layer2/saia_checks.h"
#include "client/src/layer2/frame_side.h"

namespace cansync::client::function_blocks {

void CAN_RX::call() {
  connection_->side().look();
  error_.clear();
  NDR = false;
  Status = take();
  Error = Status != can_status::done && Status != can_status::no_data;
}

WORD CAN_RX::take() {
  detail::FrameSide& side = connection_->side();
  if (PortID != 0) return refuse(can_status::wrong_port, kOnlyPort);
  if (!is_object(ObjID)) return refuse(can_status::wrong_identifier, no_object(ObjID));
  if (std::string obstacle = side.obstacle(); !obstacle.empty())
    return refuse(can_status::refused, std::move(obstacle));
  const auto number = static_cast<unsigned>(ObjID);
  if (side.reserved(number) || !side.objects().ready(number, false))
    return refuse(can_status::denied, not_set_up(ObjID, "receives"));
  const detail::Reading reading = side.objects().read(number, RxData.size(), ReleaseRx, RTR);
  error_ = reading.reason;
  if (!reading.frame) return reading.code;
  NDR = true;
  MsgID = reading.frame->id;
  DLC = reading.frame->dlc;
  std::copy_n(reading.frame->data.begin(), reading.frame->dlc, RxData.begin());
  return reading.code;
}

WORD CAN_RX::refuse(WORD code, std::string reason) {
  error_ = std::move(reason);
  return code;
}

}  // namespace cansync::client::function_blocks
