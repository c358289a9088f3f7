#pragma once

#include <linux/can.h>

#include "can/frame.h"

namespace can {

/// A frame as the kernel hands it over; its data bytes beyond the DLC, and those of a remote frame, are 0. An
/// error frame has its class bits (CAN_ERR_*) as identifier. Pure; realtime safe.
Frame from_kernel(const can_frame& frame) noexcept;

/// The other way round. A frame of kind `error` is for nobody to send. Pure; realtime safe.
can_frame to_kernel(const Frame& frame) noexcept;

}  // namespace can
