#include <cansync/function_blocks/layer2/can_status.h>
#include <cansync/function_blocks/layer2/can_tx.h>
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "client/src/function_blocks/layer2/saia_checks.h"
#include "client/src/layer2/frame_side.h"
#include "text/counts.h"

namespace cansync::client::function_blocks {

void CAN_TX::call() {
  connection_->side().look();
  error_.clear();
  Done = false;
  const BOOL rose = Act && !acted_;
  acted_ = Act;
  Status = look(rose);
  Error = Status != can_status::done && Status != can_status::in_execution && Status != can_status::aborted;
}

WORD CAN_TX::look(BOOL rose) {
  detail::FrameSide& side = connection_->side();
  if (PortID != 0) return refuse(can_status::wrong_port, kOnlyPort);
  if (!is_object(ObjID)) return refuse(can_status::wrong_identifier, no_object(ObjID));
  if (std::string obstacle = side.obstacle(); !obstacle.empty())
    return refuse(can_status::refused, std::move(obstacle));
  const auto number = static_cast<unsigned>(ObjID);
  if (side.reserved(number) || !side.objects().ready(number, true))
    return refuse(can_status::denied, not_set_up(ObjID, "sends"));
  if (Abort) {
    side.objects().abort(number);
  } else if (rose) {
    return start();
  }
  const detail::JobStatus job = side.objects().job(number);
  Done = job.done;
  error_ = job.reason;
  return job.code;
}

WORD CAN_TX::start() {
  detail::FrameSide& side = connection_->side();
  if (DLC < 0 || DLC > 8)
    return refuse(can_status::wrong_length, fmt::format("client: DLC {}: allowed 0..8", DLC));
  if (TxData.size() < static_cast<std::size_t>(DLC))
    return refuse(can_status::wrong_parameter, fmt::format("client: TxData: it has {}; DLC {} needs as many",
                                                           text::counted(TxData.size(), "byte"), DLC));
  const auto number = static_cast<unsigned>(ObjID);
  can::Frame frame;
  frame.extended = side.objects().settings(number).extended;
  frame.id = MsgID;
  frame.dlc = static_cast<std::uint8_t>(DLC);
  std::copy_n(TxData.begin(), DLC, frame.data.begin());
  if (frame.id != frame.identifier())
    return refuse(can_status::wrong_identifier, wrong_identifier(MsgID, frame.extended));
  // Done in the call that gives a job is that of the job before.
  const detail::JobStatus before = side.objects().job(number);
  const detail::JobStatus begun = side.objects().send(number, frame, RTR, MultipleTx);
  Done = before.done;
  error_ = begun.reason;
  return Done && begun.code == can_status::in_execution ? can_status::done : begun.code;
}

WORD CAN_TX::refuse(WORD code, std::string reason) {
  error_ = std::move(reason);
  return code;
}

}  // namespace cansync::client::function_blocks
