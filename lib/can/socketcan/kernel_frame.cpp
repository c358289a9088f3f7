#include "can/socketcan/kernel_frame.h"

#include <algorithm>

namespace can {
namespace {

void want(can_filter& filter, canid_t flag, FlagFilter wanted) noexcept {
  if (wanted != FlagFilter::either) filter.can_mask |= flag;
  if (wanted == FlagFilter::set) filter.can_id |= flag;
}

}  // namespace

Frame from_kernel(const can_frame& in) noexcept {
  Frame out;
  out.id = in.can_id & CAN_EFF_MASK;
  out.error = (in.can_id & CAN_ERR_FLAG) != 0;
  if (!out.error) {
    out.extended = (in.can_id & CAN_EFF_FLAG) != 0;
    out.remote = (in.can_id & CAN_RTR_FLAG) != 0;
  }
  out.id = out.identifier();
  out.dlc = std::min<std::uint8_t>(in.len, CAN_MAX_DLEN);
  if (!out.remote) std::copy_n(in.data, out.dlc, out.data.begin());
  return out;
}

can_frame to_kernel(const Frame& in) noexcept {
  can_frame out{};
  out.can_id = in.identifier();
  if (in.error) {
    out.can_id |= CAN_ERR_FLAG;
  } else {
    if (in.extended) out.can_id |= CAN_EFF_FLAG;
    if (in.remote) out.can_id |= CAN_RTR_FLAG;
  }
  out.len = std::min<std::uint8_t>(in.dlc, CAN_MAX_DLEN);
  if (!in.remote) std::copy_n(in.data.begin(), out.len, out.data);
  return out;
}

can_filter to_kernel(const FrameFilter& in) noexcept {
  can_filter out{in.identifier & CAN_EFF_MASK, in.mask & CAN_EFF_MASK};
  want(out, CAN_EFF_FLAG, in.extended);
  want(out, CAN_RTR_FLAG, in.remote);
  return out;
}

}  // namespace can
