#include "daemon/bus/bus_obstacle.h"

namespace cansyncd {

can::Obstacle obstacle_of(can::SendResult result) noexcept {
  switch (result) {
    case can::SendResult::queued:
      return can::Obstacle::none;
    case can::SendResult::queue_full:
      return can::Obstacle::queue_full;
    case can::SendResult::bus_off:
      return can::Obstacle::bus_off;
    case can::SendResult::interface_down:
      return can::Obstacle::interface_down;
    case can::SendResult::not_delivered:
      break;
  }
  return can::Obstacle::not_delivered;
}

can::Obstacle obstacle_of(const can::ControllerStatus& status) noexcept {
  if (status.link != can::LinkState::up) return can::Obstacle::interface_down;
  if (status.state == can::ControllerState::bus_off) return can::Obstacle::bus_off;
  if (status.delivery != can::Delivery::normal) return can::Obstacle::not_delivered;
  return can::Obstacle::none;
}

}  // namespace cansyncd
