#include <cansync/function_blocks/layer2/canrcv.h>
#include <cansync/function_blocks/module_codes.h>

#include "client/src/function_blocks/layer2/module_frame.h"
#include "client/src/layer2/frame_side.h"

namespace cansync::client::function_blocks {

void CANRCV::call() {
  detail::FrameSide& side = connection_->side();
  side.look();
  auto taken = side.queues().take();
  while (taken && taken->first.extended != (width_ == IdentifierWidth::bits_29)) taken = side.queues().take();
  Rcvd = taken.has_value();
  if (taken) {
    const can::Frame& frame = taken->first;
    IDHI = static_cast<WORD>(frame.id >> 16);
    IDLO = static_cast<WORD>(frame.id);
    RTRLEN = static_cast<WORD>(frame.dlc | (frame.remote ? kRemoteBit : WORD{0}) |
                               (taken->second ? kHighPriorityBit : WORD{0}));
    DW0 = word_of(frame.data, 0);
    DW1 = word_of(frame.data, 1);
    DW2 = word_of(frame.data, 2);
    DW3 = word_of(frame.data, 3);
  }
  error_ = side.obstacle();
  RETVAL = error_.empty() ? module_code::done : module_code::not_ready;
  STAT = side.status_word();
}

}  // namespace cansync::client::function_blocks
