#pragma once

#include <linux/can.h>

#include "can/frame.h"
#include "can/frame_filter.h"

namespace can {

/// A frame as the kernel hands it over; its data bytes beyond the DLC, and those of a remote frame, are 0. An
/// error frame has its class bits (CAN_ERR_*) as identifier. Pure; realtime safe.
Frame from_kernel(const can_frame& frame) noexcept;

/// The other way round. Error frames are for nobody to send. Pure; realtime safe.
can_frame to_kernel(const Frame& frame) noexcept;

/// A receive filter as CAN_RAW_FILTER takes it. Error frames have a mask of their own (CAN_RAW_ERR_FILTER).
/// Pure; realtime safe.
can_filter to_kernel(const FrameFilter& filter) noexcept;

}  // namespace can
