#include "can/kernel_frame.h"

#include <algorithm>

namespace can {

Frame from_kernel(const can_frame& in) noexcept {
  Frame out;
  if ((in.can_id & CAN_ERR_FLAG) != 0) {
    out.kind = FrameKind::error;
    out.id = in.can_id & CAN_ERR_MASK;
  } else {
    const bool extended = (in.can_id & CAN_EFF_FLAG) != 0;
    out.kind = extended ? FrameKind::extended : FrameKind::standard;
    if ((in.can_id & CAN_RTR_FLAG) != 0) out.kind = FrameKind::remote;
    out.id = in.can_id & (extended ? CAN_EFF_MASK : CAN_SFF_MASK);
  }
  out.dlc = std::min<std::uint8_t>(in.len, CAN_MAX_DLEN);
  if (out.kind != FrameKind::remote) std::copy_n(in.data, out.dlc, out.data.begin());
  return out;
}

can_frame to_kernel(const Frame& in) noexcept {
  can_frame out{};
  out.can_id = in.id;
  if (in.kind == FrameKind::extended || in.id > CAN_SFF_MASK) out.can_id |= CAN_EFF_FLAG;
  if (in.kind == FrameKind::remote) out.can_id |= CAN_RTR_FLAG;
  out.len = std::min<std::uint8_t>(in.dlc, CAN_MAX_DLEN);
  if (in.kind != FrameKind::remote) std::copy_n(in.data.begin(), out.len, out.data);
  return out;
}

}  // namespace can
