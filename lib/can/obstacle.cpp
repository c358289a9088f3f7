#include "can/obstacle.h"

namespace can {

std::string_view reason_not_sent(Obstacle obstacle) noexcept {
  switch (obstacle) {
    case Obstacle::none:
      break;
    case Obstacle::queue_full:
      return "not sent within the monitoring time: the controller's queue was full; check the load of the bus "
             "and that somebody acknowledges";
    case Obstacle::bus_off:
      return "not sent within the monitoring time: the controller is in bus-off; check wiring, termination and "
             "bit rate; it leaves bus-off by its interface's restart-ms, or when the interface is set up anew";
    case Obstacle::interface_down:
      return "not sent within the monitoring time: the interface is missing, down, in listen-only mode, or not "
             "set up as configured; look at it, and set it up with the configured bit rate, and not listen-only";
    case Obstacle::not_delivered:
      return "not sent within the monitoring time: nobody acknowledges; check that another node is on the bus, "
             "with the same bit rate";
    case Obstacle::window_closed:
      return "not sent within the monitoring time: the synchronous window was closed, or had no room for "
             "all that waited; send less, make the window longer (window.end_us), or give a timeout longer than "
             "window.repeat_us";
  }
  return "not sent within the monitoring time: earlier frames kept the bus; send less, or give a longer "
         "timeout";
}

}  // namespace can
