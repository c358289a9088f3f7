#include "daemon/loop/controller_watch.h"

#include <chrono>

namespace cansyncd {
namespace {

constexpr can::Time kSecond = std::chrono::seconds(1);

}  // namespace

void ControllerWatch::begin(can::Time now) noexcept {
  clock_.adjust(bus_);
  load_.take(now);
  next_second_ = now + kSecond;
  controller_ = bus_.status();
}

ControllerWatch::News ControllerWatch::turn(can::Time now) noexcept {
  ++turns_;
  const Moment moment{turns_, now, clock_.at(now)};
  if (tap_ != nullptr) tap_->at(moment);
  if (now >= next_second_) {
    next_second_ = now + kSecond;
    clock_.adjust(bus_);
    last_load_ = load_.take(now);
  }
  const can::ControllerStatus before = controller_;
  controller_ = bus_.status();
  if (tap_ != nullptr) record(before, moment);
  News news;
  news.emptied = controller_.unacknowledged != before.unacknowledged ||
                 controller_.restarts != before.restarts ||
                 (controller_.link != before.link && controller_.link != can::LinkState::up);
  news.echoes_lost = !news.emptied && controller_.dropped != before.dropped;
  news.changed = controller_.state != before.state || controller_.link != before.link ||
                 controller_.delivery != before.delivery;
  return news;
}

/// Tells the flight recorder, which must be there, what changed since `before`.
void ControllerWatch::record(const can::ControllerStatus& before, const Moment& moment) noexcept {
  const auto not_sent = [&](can::SendResult result) {
    tap_->fault(FlightReason::sending_failed, static_cast<std::uint64_t>(result), moment);
  };
  if (controller_.state != before.state) tap_->controller(moment, controller_.state);
  if (controller_.link != before.link && controller_.link != can::LinkState::up)
    not_sent(can::SendResult::interface_down);
  if (controller_.delivery != before.delivery && before.delivery == can::Delivery::normal)
    not_sent(can::SendResult::not_delivered);
}

}  // namespace cansyncd
