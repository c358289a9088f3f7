#pragma once

#include "can/bus.h"
#include "can/obstacle.h"

namespace cansyncd {

/// By what became of a frame that was handed over. Realtime safe.
can::Obstacle obstacle_of(can::SendResult result) noexcept;

/// What keeps the controller from sending what it has; none: other frames. Realtime safe.
can::Obstacle obstacle_of(const can::ControllerStatus& status) noexcept;

}  // namespace cansyncd
