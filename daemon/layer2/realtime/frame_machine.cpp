#include "daemon/layer2/realtime/frame_machine.h"

#include <algorithm>
#include <chrono>
#include <variant>

#include "daemon/bus/bus_obstacle.h"

namespace cansyncd {
namespace {

/// Requests taken at once: the work they make must not keep frames waiting.
constexpr unsigned kRequestsAtOnce = 32;
constexpr can::Time kStatusPeriod = std::chrono::milliseconds(100);
/// Received frames alone wake the gateway no more often: at full load it takes several at once, which costs
/// less processor time. Those that wait go with the next turn of the loop, a look later at most.
constexpr can::Time kFramesRest = std::chrono::microseconds(500);
/// Image and objects are passed on no more often.
constexpr can::Time kImagePeriod = std::chrono::milliseconds(10);

layer2::OrderId id_of(const Layer2Request& request) noexcept {
  if (const auto* frame = std::get_if<layer2::SendOrder>(&request)) return frame->id;
  if (const auto* control = std::get_if<layer2::ControlOrder>(&request)) return control->id;
  if (const auto* object = std::get_if<layer2::ObjectOrder>(&request)) return object->id;
  return 0;  // a cancel has no answer of its own
}

}  // namespace

void FrameMachine::begin(can::Time now) noexcept {
  watch_.begin(now);
  next_status_ = now;
  changed_ = true;  // nobody has been told how the bus is
  module_.begin(now);
}

void FrameMachine::advance(can::Time now) noexcept {
  watch_bus(now);
  if (reset_) finish_reset(bus_.reset_result());
  take_outputs();
  take_requests(now);
  module_.advance(now);
}

void FrameMachine::watch_bus(can::Time now) noexcept {
  const ControllerWatch::News news = watch_.turn(now);
  if (news.emptied) module_.controller_emptied();
  if (news.echoes_lost) module_.echoes_lost();
  if (news.changed) changed_ = true;
  // The bus is not asked about a frame that has no place in the controller.
  if (!module_.station().has_place()) module_.held_back(obstacle_of(watch_.controller()));
}

void FrameMachine::take_requests(can::Time now) noexcept {
  Layer2Request request;
  for (unsigned i = 0; i < kRequestsAtOnce && exchange_.done.room() > unanswered_; ++i) {
    if (!exchange_.requests.try_pop(request)) return;
    take_request(request, now);
  }
}

void FrameMachine::take_request(const Layer2Request& request, can::Time now) noexcept {
  if (const auto* cancel = std::get_if<CancelOrder>(&request)) {
    if (!module_.cancel(cancel->id)) (void)module_.cancel_object(cancel->id);
    return;
  }
  ++unanswered_;
  if (const auto* order = std::get_if<layer2::ControlOrder>(&request)) {
    control(*order, now);
  } else if (const auto* object = std::get_if<layer2::ObjectOrder>(&request)) {
    if (const auto done = module_.perform(*object, now)) answer_object(*done);
  } else if (const auto* frame = std::get_if<layer2::SendOrder>(&request)) {
    const layer2::Refusal refusal = module_.submit(*frame, now);
    if (refusal != layer2::Refusal::none) answer({{.id = frame->id}, refusal, {}});
  }
}

void FrameMachine::take_outputs() noexcept {
  if (!exchange_.outputs.read(outputs_)) return;
  if (outputs_.table != module_.mapping().table()) return;  // given for the one before
  std::copy(outputs_.bytes.begin(), outputs_.bytes.end(), module_.mapping().outputs().begin());
  module_.mapping().set_sending(outputs_.sending);
}

void FrameMachine::control(const layer2::ControlOrder& order, can::Time now) noexcept {
  changed_ = true;
  if (order.what == layer2::Control::write_image) take_outputs();  // given before its order
  if (order.what == layer2::Control::reset_overflow) known_lost_ = watch_.controller().lost_frames();
  if (order.what != layer2::Control::reset_controller) {
    const layer2::Refusal refusal = module_.control(order, now);
    answer({{.id = order.id}, refusal, {}});
  } else if (reset_) {
    answer({{.id = order.id}, layer2::Refusal::reset_under_way, {}});
  } else {
    reset_ = order.id;
    const can::ResetResult result = bus_.reset();
    // One that takes its time is seen in the bus's status: a frame may be in the controller again by its end.
    if (result == can::ResetResult::done) module_.controller_emptied();
    finish_reset(result);
  }
}

void FrameMachine::finish_reset(can::ResetResult result) noexcept {
  if (result == can::ResetResult::pending) return;
  layer2::Refusal refusal = layer2::Refusal::none;
  if (result == can::ResetResult::not_permitted) refusal = layer2::Refusal::not_permitted;
  if (result == can::ResetResult::unavailable) refusal = layer2::Refusal::no_controller;
  if (result == can::ResetResult::done) known_lost_ = watch_.controller().lost_frames();
  answer({{.id = *reset_}, refusal, {}});
  reset_.reset();
}

void FrameMachine::receive(const can::ReceivedFrame& received) noexcept {
  watch_.add(received.frame);
  if (received.own) {
    module_.echo(received.frame, received.end);
    return;
  }
  module_.receive(received.frame, received.end);
  pass_received();
}

/// What the gateway has no room for waits in the module's queues.
void FrameMachine::pass_received() noexcept {
  while (exchange_.frames.room() > 0) {
    const auto waiting = module_.take_received();
    if (!waiting) return;
    (void)exchange_.frames.try_push({waiting->frame, watch_.wall_clock(waiting->end), waiting->range,
                                     waiting->priority == layer2::Priority::high});
    frames_pending_ = true;
  }
}

void FrameMachine::handed_over(can::SendResult result) noexcept {
  if (result == can::SendResult::queued) {
    module_.handed_over();
  } else {
    module_.held_back(obstacle_of(result));
  }
}

void FrameMachine::answer(const SendDone& done) noexcept {
  // There is room: no more orders are taken than have it.
  (void)exchange_.done.try_push(done);
  --unanswered_;
  pending_ = true;
}

void FrameMachine::answer_object(const layer2::ObjectAnswer& done) noexcept {
  const bool timed = done.time != can::Time{0};
  answer({{.id = done.id, .outcome = done.outcome},
          done.refusal,
          timed ? watch_.wall_clock(done.time) : can::Time{0},
          done});
}

void FrameMachine::pass_events() noexcept {
  while (const auto event = module_.take_event()) {
    (void)exchange_.events.try_push({*event, watch_.wall_clock(event->time), ++event_number_});
    pending_ = true;
  }
}

void FrameMachine::pass_answers() noexcept {
  while (const auto ended = module_.take_object_answer()) answer_object(*ended);
  while (const auto ended = module_.take_answer()) {
    const bool done = ended->outcome == layer2::Outcome::done;
    answer({*ended, layer2::Refusal::none, done ? watch_.wall_clock(ended->sent) : can::Time{0}});
  }
}

void FrameMachine::take_snapshot() noexcept {
  using layer2::Priority;
  const layer2::Station& station = module_.station();
  snapshot_.counters = station.counters();
  snapshot_.taken_by_objects = module_.taken_by_objects();
  snapshot_.taken_by_mapping = module_.mapping().received();
  snapshot_.dropped_by_mapping = module_.mapping().dropped();
  snapshot_.timestamps = bus_.timestamp_source();
  snapshot_.waiting = static_cast<std::uint32_t>(station.waiting());
  snapshot_.script_running = module_.script_runs();
  snapshot_.window_running = module_.window().runs();
  snapshot_.send = station.queue(Priority::normal);
  snapshot_.send_high = station.queue(Priority::high);
  snapshot_.receive = module_.receive_queue(Priority::normal);
  snapshot_.receive_high = module_.receive_queue(Priority::high);
  snapshot_.lost = snapshot_.receive.lost + snapshot_.receive_high.lost;
  snapshot_.facts = module_.status();
  const can::ControllerStatus& controller = watch_.controller();
  snapshot_.controller = controller;
  snapshot_.bus_load = watch_.bus_load();
  snapshot_.facts.bus_off = controller.state == can::ControllerState::bus_off;
  snapshot_.facts.stopped =
      controller.state == can::ControllerState::stopped || controller.link != can::LinkState::up;
  snapshot_.facts.receive_overrun = controller.lost_frames() != known_lost_;
  snapshot_.facts.transmit_errors = controller.transmit_errors;
  snapshot_.facts.receive_errors = controller.receive_errors;
  const layer2::Timers& timers = module_.timers();
  for (unsigned number = 1; number <= layer2::Timers::kMost; ++number) {
    snapshot_.timers[number - 1] = {timers.configured(number), timers.running(number),
                                    timers.settings(number), timers.sent(number), timers.left_out(number)};
  }
}

void FrameMachine::publish_image(can::Time now) noexcept {
  if (!module_.has_mapping() || now < next_image_) return;
  const layer2::DataMapping& mapping = module_.mapping();
  next_image_ = now + kImagePeriod;
  ImageSnapshot newest{.table = mapping.table(),
                       .exchanging = mapping.runs(),
                       .sending = mapping.sending(),
                       .received = mapping.received(),
                       .dropped = mapping.dropped(),
                       .sent = mapping.sent(),
                       .left_out = mapping.left_out(),
                       .telegrams = static_cast<std::uint8_t>(mapping.telegrams())};
  for (std::size_t i = 0; i < newest.telegrams; ++i) newest.each_left_out[i] = mapping.left_out(i);
  std::copy(mapping.inputs().begin(), mapping.inputs().end(), newest.inputs.begin());
  std::copy(mapping.outputs().begin(), mapping.outputs().end(), newest.outputs.begin());
  const bool changed = newest.exchanging != image_.exchanging || newest.sending != image_.sending ||
                       newest.inputs != image_.inputs || newest.outputs != image_.outputs;
  image_ = newest;
  exchange_.image.write(image_);
  if (changed) pending_ = true;
}

void FrameMachine::publish_objects(can::Time now) noexcept {
  const layer2::MessageObjects& objects = module_.objects();
  if (objects.changes() == told_objects_ || now < next_objects_) return;
  told_objects_ = objects.changes();
  next_objects_ = now + kImagePeriod;
  for (unsigned number = 0; number < objects_.objects.size(); ++number) {
    const layer2::ObjectState state = objects.state(number);
    if (state == objects_.objects[number]) continue;
    objects_.objects[number] = state;
    objects_.times[number] = state.time == can::Time{0} ? can::Time{0} : watch_.wall_clock(state.time);
  }
  exchange_.objects.write(objects_);
  pending_ = true;
}

void FrameMachine::publish(can::Time now) noexcept {
  pass_answers();
  pass_received();
  pass_events();
  publish_image(now);
  publish_objects(now);
  if (changed_ || now >= next_status_) {
    next_status_ = now + kStatusPeriod;
    take_snapshot();
    exchange_.status.write(snapshot_);
    // Nobody is woken for counters alone.
    if (changed_) pending_ = true;
    changed_ = false;
  }
  if (!pending_ && (!frames_pending_ || now < next_wake_)) return;
  pending_ = frames_pending_ = false;
  next_wake_ = now + kFramesRest;
  exchange_.gateway_wake.signal();
}

void FrameMachine::end(can::Time now) noexcept {
  module_.end();
  pass_answers();
  if (reset_) answer({{.id = *reset_, .outcome = layer2::Outcome::stopped}, layer2::Refusal::none, {}});
  reset_.reset();
  Layer2Request request;
  while (exchange_.done.room() > 0 && exchange_.requests.try_pop(request)) {
    if (std::get_if<CancelOrder>(&request) != nullptr) continue;
    ++unanswered_;
    answer({{.id = id_of(request), .outcome = layer2::Outcome::stopped}, layer2::Refusal::none, {}});
  }
  changed_ = true;
  publish(now);
}

}  // namespace cansyncd
