#include <cansync/function_blocks/j1939/canrcv_sae_j1939.h>
#include <cansync/function_blocks/module_codes.h>

#include <algorithm>
#include <array>

#include "client/src/j1939/message_side.h"
#include "j1939/identifier.h"

namespace cansync::client::function_blocks {

void CANRCV_SAE_J1939::call() {
  detail::MessageSide& side = connection_->side();
  side.look();
  const auto taken = side.queues().take();
  Recd = taken.has_value();
  if (taken) {
    const detail::MessageSide::Frame& frame = taken->first;
    const j1939::Identifier parts = j1939::parse(frame.identifier);
    Priority = parts.priority;
    DataPageBit = parts.data_page;
    PDU_Format = parts.format;
    PDU_Specific = parts.specific;
    Source_Addr = parts.source;
    length_ = frame.length;
    constexpr BYTE kNotAvailable = 0xFF;
    const std::array<BYTE*, 8> outputs = {&B0, &B1, &B2, &B3, &B4, &B5, &B6, &B7};
    for (std::size_t i = 0; i < outputs.size(); ++i)
      *outputs[i] = i < frame.length ? frame.bytes[i] : kNotAvailable;
  }
  error_ = side.silence();
  RETVAL = error_.empty() ? module_code::done : module_code::not_ready;
  STAT = side.status_word();
}

}  // namespace cansync::client::function_blocks
