#include "daemon/layer2/realtime/frame_machine.h"

#include <chrono>
#include <variant>

namespace cansyncd {
namespace {

/// Requests taken at once: the work they make must not keep frames waiting.
constexpr unsigned kRequestsAtOnce = 32;
constexpr can::Time kSecond = std::chrono::seconds(1);
constexpr can::Time kStatusPeriod = std::chrono::milliseconds(100);

layer2::Obstacle obstacle_of(can::SendResult result) noexcept {
  switch (result) {
    case can::SendResult::queued:
      return layer2::Obstacle::none;
    case can::SendResult::queue_full:
      return layer2::Obstacle::queue_full;
    case can::SendResult::bus_off:
      return layer2::Obstacle::bus_off;
    case can::SendResult::interface_down:
      return layer2::Obstacle::interface_down;
    case can::SendResult::not_delivered:
      break;
  }
  return layer2::Obstacle::not_delivered;
}

/// What keeps the controller from sending what it has; none: other frames.
layer2::Obstacle obstacle_of(const can::ControllerStatus& status) noexcept {
  if (status.link != can::LinkState::up) return layer2::Obstacle::interface_down;
  if (status.state == can::ControllerState::bus_off) return layer2::Obstacle::bus_off;
  if (status.delivery != can::Delivery::normal) return layer2::Obstacle::not_delivered;
  return layer2::Obstacle::none;
}

}  // namespace

void FrameMachine::begin(can::Time now) noexcept {
  clock_.adjust(bus_);
  load_.take(now);
  next_second_ = now + kSecond;
  next_status_ = now;
  snapshot_.controller = bus_.status();
  changed_ = true;  // nobody has been told how the bus is
}

void FrameMachine::advance(can::Time now) noexcept {
  ++turns_;
  if (tap_ != nullptr) tap_->at({turns_, now, clock_.at(now)});
  if (now >= next_second_) {
    next_second_ = now + kSecond;
    clock_.adjust(bus_);
    snapshot_.bus_load = load_.take(now);
  }
  watch_bus(now);
  take_requests(now);
  station_.advance(now);
}

/// What was handed over is gone when the controller was emptied, left bus-off, or lost its interface. Frames
/// that the kernel dropped may have been echoes.
void FrameMachine::watch_bus(can::Time when) noexcept {
  const can::ControllerStatus before = snapshot_.controller;
  const can::ControllerStatus now = bus_.status();
  snapshot_.controller = now;
  const bool emptied = now.unacknowledged != before.unacknowledged || now.restarts != before.restarts ||
                       (now.link != before.link && now.link != can::LinkState::up);
  if (emptied) {
    station_.controller_emptied();
  } else if (now.dropped != before.dropped) {
    station_.echoes_lost();
  }
  if (now.state != before.state || now.link != before.link || now.delivery != before.delivery)
    changed_ = true;
  if (tap_ != nullptr) record_faults(before, when);
  // The bus is not asked about a frame that has no place in the controller.
  if (station_.waiting() != 0 && station_.handed_over_count() == layer2::Station::kMostHandedOver)
    station_.held_back(obstacle_of(now));
}

/// Tells the flight recorder, which must be there, what changed since `before`.
void FrameMachine::record_faults(const can::ControllerStatus& before, can::Time when) noexcept {
  const can::ControllerStatus& now = snapshot_.controller;
  const Moment moment{turns_, when, clock_.at(when)};
  const auto not_sent = [&](can::SendResult result) {
    tap_->fault(FlightReason::sending_failed, static_cast<std::uint64_t>(result), moment);
  };
  if (now.state != before.state) tap_->controller(moment, now.state);
  if (now.link != before.link && now.link != can::LinkState::up) not_sent(can::SendResult::interface_down);
  if (now.delivery != before.delivery && before.delivery == can::Delivery::normal)
    not_sent(can::SendResult::not_delivered);
}

void FrameMachine::take_requests(can::Time now) noexcept {
  Layer2Request request;
  for (unsigned i = 0; i < kRequestsAtOnce && exchange_.done.room() > unanswered_; ++i) {
    if (!exchange_.requests.try_pop(request)) return;
    if (const auto* cancel = std::get_if<CancelOrder>(&request)) {
      station_.cancel(cancel->id);
      continue;
    }
    const auto& order = *std::get_if<layer2::SendOrder>(&request);
    ++unanswered_;
    const layer2::Refusal refusal = station_.submit(order, now);
    if (refusal != layer2::Refusal::none) answer({{.id = order.id}, refusal, {}});
  }
}

void FrameMachine::receive(const can::ReceivedFrame& received) noexcept {
  load_.add(received.frame);
  if (received.own) {
    station_.echo(received.frame, received.end);
    return;
  }
  const auto range = station_.receive(received.frame);
  if (!range) return;
  if (exchange_.frames.try_push({received.frame, clock_.at(received.end), *range})) {
    pending_ = true;
  } else {
    ++snapshot_.lost;
  }
}

void FrameMachine::handed_over(can::SendResult result) noexcept {
  if (result == can::SendResult::queued) {
    station_.handed_over();
  } else {
    station_.held_back(obstacle_of(result));
  }
}

void FrameMachine::answer(const SendDone& done) noexcept {
  // There is room: no more orders are taken than have it.
  (void)exchange_.done.try_push(done);
  --unanswered_;
  pending_ = true;
}

void FrameMachine::pass_answers() noexcept {
  while (const auto ended = station_.take_answer()) {
    const bool done = ended->outcome == layer2::Outcome::done;
    answer({*ended, layer2::Refusal::none, done ? clock_.at(ended->sent) : can::Time{0}});
  }
}

void FrameMachine::publish(can::Time now) noexcept {
  pass_answers();
  if (changed_ || now >= next_status_) {
    next_status_ = now + kStatusPeriod;
    snapshot_.counters = station_.counters();
    snapshot_.timestamps = bus_.timestamp_source();
    snapshot_.waiting = static_cast<std::uint32_t>(station_.waiting());
    exchange_.status.write(snapshot_);
    // Nobody is woken for counters alone.
    if (changed_) pending_ = true;
    changed_ = false;
  }
  if (!pending_) return;
  pending_ = false;
  exchange_.gateway_wake.signal();
}

void FrameMachine::end(can::Time now) noexcept {
  station_.stop();
  pass_answers();
  Layer2Request request;
  while (exchange_.done.room() > 0 && exchange_.requests.try_pop(request)) {
    const auto* order = std::get_if<layer2::SendOrder>(&request);
    if (order == nullptr) continue;
    ++unanswered_;
    answer({{.id = order->id, .outcome = layer2::Outcome::stopped}, layer2::Refusal::none, {}});
  }
  changed_ = true;
  publish(now);
}

}  // namespace cansyncd
