#include "layer2/object_orders.h"

#include <algorithm>

namespace layer2 {
namespace {

Refusal refusal_of(ObjectProblem problem) noexcept {
  switch (problem) {
    case ObjectProblem::none:
      return Refusal::none;
    case ObjectProblem::reserved:
      return Refusal::object_reserved;
    case ObjectProblem::direction:
      return Refusal::object_direction;
    case ObjectProblem::pending:
      return Refusal::object_pending;
    case ObjectProblem::number:
    case ObjectProblem::frame:
      break;
  }
  return Refusal::object_frame;
}

}  // namespace

std::optional<ObjectAnswer> ObjectOrders::perform(const ObjectOrder& order, bool running, Time now) noexcept {
  now_ = now;
  ObjectAnswer answer{.id = order.id};
  switch (order.kind) {
    case ObjectOrder::Kind::configure:
      return configure(order);
    case ObjectOrder::Kind::read:
      if (order.release && order.ask && (stopped_ || !running)) break;
      return read(order);
    case ObjectOrder::Kind::abort: {
      const bool known = order.number < MessageObjects::kMost && objects_.state(order.number).configured;
      if (!known || !objects_.state(order.number).settings.transmit) {
        answer.refusal = Refusal::object_direction;
      } else if (objects_.place(order.number) == JobPlace::in_controller) {
        answer.refusal = Refusal::object_pending;
      } else {
        (void)objects_.abort(order.number);
      }
      return answer;
    }
    case ObjectOrder::Kind::send:
      break;
  }
  if (stopped_ || !running) {
    answer.refusal = stopped_ ? Refusal::stopped : Refusal::not_running;
    return answer;
  }
  // A job whose end was not fetched yet keeps its order.
  if (order.number < open_.size() && open_[order.number].used) {
    answer.refusal = Refusal::object_pending;
    return answer;
  }
  answer.refusal = refusal_of(objects_.start(order.number, order.job, now));
  if (answer.refusal != Refusal::none) return answer;
  answer.job_number = objects_.state(order.number).job_number;
  if (order.job.on_remote) return answer;
  if (jobs_ == 0) obstacle_ = Obstacle::none;
  open_[order.number] = {order.id, true, Time::max()};
  ++jobs_;
  return std::nullopt;
}

ObjectAnswer ObjectOrders::configure(const ObjectOrder& order) noexcept {
  ObjectAnswer answer{.id = order.id};
  for (std::size_t i = 0; i < order.settings.size(); ++i) {
    const ObjectEntry& entry = order.settings[i];
    const ObjectProblem problem = objects_.check(entry.number, entry.settings);
    if (problem == ObjectProblem::none) continue;
    answer.refusal = refusal_of(problem);
    answer.place = static_cast<std::uint8_t>(i);
    return answer;
  }
  if (order.anew) objects_.reset();
  for (const ObjectEntry& entry : order.settings) (void)objects_.configure(entry.number, entry.settings);
  return answer;
}

ObjectAnswer ObjectOrders::read(const ObjectOrder& order) noexcept {
  ObjectAnswer answer{.id = order.id};
  if (order.number >= MessageObjects::kMost) {
    answer.refusal = Refusal::object_direction;
    return answer;
  }
  const ObjectState state = objects_.state(order.number);
  if (!state.configured || state.settings.transmit) {
    answer.refusal = Refusal::object_direction;
    return answer;
  }
  if (order.release && order.ask && state.place != JobPlace::none) {
    answer.refusal = Refusal::object_pending;  // the frame it has stays where it is
    return answer;
  }
  if (const auto reading = objects_.read(order.number, order.release)) {
    answer.fresh = true;
    answer.reading = *reading;
    answer.time = reading->end;
  }
  if (order.release) answer.refusal = refusal_of(objects_.release(order.number, order.ask));
  return answer;
}

bool ObjectOrders::cancel(OrderId id) noexcept {
  for (unsigned number = 0; number < open_.size(); ++number) {
    if (!open_[number].used || open_[number].id != id) continue;
    (void)objects_.abort(number);
    return true;
  }
  return false;
}

std::optional<ObjectAnswer> ObjectOrders::take_answer() noexcept {
  if (jobs_ == 0) return std::nullopt;
  for (unsigned number = 0; number < open_.size(); ++number) {
    Open& open = open_[number];
    if (!open.used) continue;
    ObjectAnswer answer{.id = open.id, .outcome = Outcome::cancelled};
    answer.job_number = objects_.state(number).job_number;
    switch (objects_.take_state(number)) {
      case JobState::under_way:
        if (stopped_) {
          const bool handed = objects_.place(number) == JobPlace::in_controller;
          answer.outcome = outcome_of(handed ? JobKnown::handed_over : JobKnown::not_sent, JobEnd::stopped);
        } else if (open.until <= now_) {
          answer.outcome = outcome_of(JobKnown::handed_over, JobEnd::time);
        } else {
          continue;
        }
        break;
      case JobState::done:
        answer.outcome = Outcome::done;
        answer.time = objects_.state(number).time;
        break;
      case JobState::timed_out:
        // What was handed over and is gone from the controller may have been sent.
        answer.outcome =
            outcome_of(open.until == Time::max() ? JobKnown::not_sent : JobKnown::handed_over, JobEnd::time);
        if (answer.outcome == Outcome::timeout) answer.obstacle = obstacle_;
        break;
      case JobState::aborted:
      case JobState::none:  // configured anew as one that receives
        if (open.until != Time::max()) answer.outcome = outcome_of(JobKnown::handed_over, JobEnd::time);
        break;
    }
    open.used = false;
    --jobs_;
    return answer;
  }
  return std::nullopt;
}

void ObjectOrders::handed_over(unsigned number, Time now) noexcept {
  if (number < open_.size() && open_[number].used) open_[number].until = now + patience_;
}

Time ObjectOrders::next_deadline() const noexcept {
  Time next = Time::max();
  if (jobs_ == 0) return next;
  for (const Open& open : open_) {
    if (open.used) next = std::min(next, open.until);
  }
  return next;
}

}  // namespace layer2
