#include "layer2/message_objects.h"

#include <algorithm>

namespace layer2 {
namespace {

constexpr std::uint32_t largest(bool extended) noexcept {
  return extended ? can::kExtendedIdentifierMask : can::kStandardIdentifierMask;
}

}  // namespace

bool takes(const MaskRule& rule, const can::Frame& frame) noexcept {
  if (frame.error || frame.extended != rule.extended) return false;
  return ((frame.identifier() ^ rule.identifier) & rule.mask & largest(rule.extended)) == 0;
}

ObjectProblem MessageObjects::check(unsigned number, const ObjectSettings& settings) const noexcept {
  if (number >= kMost) return ObjectProblem::number;
  if (objects_[number].reserved) return ObjectProblem::reserved;
  if (settings.rule.identifier > largest(settings.rule.extended)) return ObjectProblem::frame;
  return ObjectProblem::none;
}

ObjectProblem MessageObjects::configure(unsigned number, const ObjectSettings& settings) noexcept {
  if (const auto problem = check(number, settings); problem != ObjectProblem::none) return problem;
  Object& object = objects_[number];
  renew(object);
  object.settings = settings;
  object.configured = true;
  if (!settings.transmit) object.told = JobState::none;
  return ObjectProblem::none;
}

/// As if it had never been configured, but for its counters; the end of a job is to be told.
void MessageObjects::renew(Object& object) noexcept {
  ++changes_;
  const bool had_job = object.phase != Phase::none && !object.request;
  const bool reserved = object.reserved;
  const std::uint32_t handings = object.handings;
  ObjectState count = object.count;
  // A frame in the controller may be sent yet, whatever becomes of its object.
  const bool handed_over = object.phase == Phase::in_controller && !object.request;
  const JobState as = handed_over ? JobState::timed_out : JobState::aborted;
  const std::uint32_t on_its_way = handed_over ? object.handings : object.on_its_way;
  if (had_job) count.ended_as = as;
  object = {};
  object.reserved = reserved;
  object.handings = handings;
  object.on_its_way = on_its_way;
  object.count = count;
  if (had_job) object.told = as;
}

bool MessageObjects::forget(unsigned number) noexcept {
  if (number >= kMost) return false;
  renew(objects_[number]);
  return true;
}

void MessageObjects::reserve(unsigned number) noexcept {
  if (!forget(number)) return;
  objects_[number].reserved = true;
}

void MessageObjects::unreserve(unsigned number) noexcept {
  if (number < kMost) objects_[number].reserved = false;
}

void MessageObjects::reset() noexcept {
  for (Object& object : objects_) renew(object);
}

ObjectProblem MessageObjects::access(unsigned number, bool transmit) const noexcept {
  if (number >= kMost) return ObjectProblem::number;
  const Object& object = objects_[number];
  if (object.reserved) return ObjectProblem::reserved;
  if (!object.configured || object.settings.transmit != transmit) return ObjectProblem::direction;
  return ObjectProblem::none;
}

ObjectProblem MessageObjects::start(unsigned number, const ObjectJob& job, Time now) noexcept {
  if (const ObjectProblem problem = access(number, true); problem != ObjectProblem::none) return problem;
  Object& object = objects_[number];
  const can::Frame& frame = job.frame;
  if (frame.error || frame.remote || frame.dlc > frame.data.size() ||
      frame.extended != object.settings.rule.extended || frame.id > largest(frame.extended))
    return ObjectProblem::frame;
  const bool replaceable = object.phase == Phase::none || object.phase == Phase::waits_for_remote;
  if (!replaceable) return ObjectProblem::pending;
  ++changes_;
  object.job = job;
  ++object.count.job_number;
  object.count.job_sent = 0;
  object.phase = job.on_remote ? Phase::waits_for_remote : Phase::ready;
  object.told = JobState::none;
  object.asked_again = false;
  object.until = object.settings.timeout > Time{0} ? now + object.settings.timeout : Time::max();
  return ObjectProblem::none;
}

bool MessageObjects::abort(unsigned number) noexcept {
  if (number >= kMost) return false;
  Object& object = objects_[number];
  if (object.phase == Phase::none || object.phase == Phase::in_controller) return false;
  end_job(object, JobState::aborted);
  return true;
}

/// Of an object that receives, only the frame that asks is not sent.
void MessageObjects::end_job(Object& object, JobState as) noexcept {
  ++changes_;
  object.phase = Phase::none;
  object.until = Time::max();
  if (!object.request) object.told = object.count.ended_as = as;
  object.request = false;
}

JobState MessageObjects::take_state(unsigned number) noexcept {
  if (number >= kMost) return JobState::none;
  Object& object = objects_[number];
  const JobState told = object.told;
  object.told = JobState::none;
  if (told != JobState::none) return told;
  return object.phase == Phase::none ? JobState::none : JobState::under_way;
}

std::optional<unsigned> MessageObjects::next() const noexcept {
  for (unsigned number = 0; number < kMost; ++number) {
    if (objects_[number].phase == Phase::ready) return number;
  }
  return std::nullopt;
}

std::uint32_t MessageObjects::handed_over(unsigned number) noexcept {
  if (number >= kMost || objects_[number].phase != Phase::ready) return 0;
  ++changes_;
  objects_[number].phase = Phase::in_controller;
  return ++objects_[number].handings;
}

bool MessageObjects::sent(unsigned number, std::uint32_t handing, Time end) noexcept {
  if (number >= kMost) return false;
  Object& object = objects_[number];
  if (object.on_its_way == handing && handing != 0) {
    ++changes_;
    object.on_its_way = 0;
    object.count.time = end;
    ++object.count.sent;
    return false;
  }
  if (object.phase != Phase::in_controller || object.handings != handing) return false;
  if (object.request) {  // the remote frame of an object that receives
    ++changes_;
    object.request = false;
    object.phase = Phase::none;
    return true;
  }
  object.count.time = end;
  ++object.count.sent;
  ++object.count.job_sent;
  end_job(object, JobState::done);
  if (!object.job.on_remote || !object.job.every_time) return true;
  object.phase = object.asked_again ? Phase::ready : Phase::waits_for_remote;
  object.asked_again = false;
  return true;
}

/// Ends the job of an object in the controller, of whose frame nobody knows.
void MessageObjects::give_up(Object& object) noexcept {
  const bool goes_on = object.job.every_time && !object.request;
  end_job(object, JobState::timed_out);
  if (goes_on) object.phase = Phase::waits_for_remote;
}

void MessageObjects::lost(unsigned number, std::uint32_t handing) noexcept {
  if (number >= kMost) return;
  Object& object = objects_[number];
  if (object.phase != Phase::in_controller || object.handings != handing) return;
  give_up(object);
  if (object.asked_again && object.phase == Phase::waits_for_remote) object.phase = Phase::ready;
  object.asked_again = false;
}

void MessageObjects::controller_emptied() noexcept {
  for (Object& object : objects_) {
    if (object.phase != Phase::in_controller) continue;
    give_up(object);
    object.asked_again = false;
  }
}

void MessageObjects::stop() noexcept {
  for (unsigned number = 0; number < kMost; ++number) {
    if (abort(number)) continue;
    objects_[number].job.every_time = false;
    objects_[number].asked_again = false;
  }
}

ObjectProblem MessageObjects::release(unsigned number, bool request) noexcept {
  if (const ObjectProblem problem = access(number, false); problem != ObjectProblem::none) return problem;
  Object& object = objects_[number];
  if (request && object.phase != Phase::none) return ObjectProblem::pending;
  ++changes_;
  object.open = true;
  if (!request) return ObjectProblem::none;
  object.job = {};
  object.job.frame.id = object.settings.rule.identifier;
  object.job.frame.extended = object.settings.rule.extended;
  object.job.frame.remote = true;
  object.request = true;
  object.phase = Phase::ready;
  return ObjectProblem::none;
}

void MessageObjects::answer_remote(const can::Frame& frame) noexcept {
  for (Object& object : objects_) {
    const can::Frame& held = object.job.frame;
    if (!object.job.on_remote || held.extended != frame.extended || held.id != frame.identifier()) continue;
    if (object.phase == Phase::waits_for_remote) {
      ++changes_;
      object.phase = Phase::ready;
      return;
    }
    if (object.job.every_time && object.phase == Phase::in_controller) {
      object.asked_again = true;
      return;
    }
  }
}

std::optional<unsigned> MessageObjects::receive(const can::Frame& frame, Time end) noexcept {
  if (frame.remote && !frame.error) answer_remote(frame);
  if (frame.remote) return std::nullopt;
  for (unsigned number = 0; number < kMost; ++number) {
    Object& object = objects_[number];
    if (!object.configured || object.settings.transmit || !takes(object.settings.rule, frame)) continue;
    if (object.full) {
      ++changes_;
      ++object.count.overruns;
      object.overrun = true;
      continue;
    }
    if (!object.open) continue;
    object.open = false;
    object.full = true;
    ++changes_;
    ++object.count.received;
    object.count.time = end;
    object.received = {frame, end};
    return number;
  }
  return std::nullopt;
}

std::optional<ObjectReading> MessageObjects::read(unsigned number, bool release_anew) noexcept {
  if (number >= kMost || !objects_[number].full) return std::nullopt;
  Object& object = objects_[number];
  ++changes_;
  const ObjectReading reading{object.received.frame, object.received.end, object.overrun};
  object.full = false;
  object.overrun = false;
  object.open = release_anew;
  return reading;
}

void MessageObjects::advance(Time now) noexcept {
  for (Object& object : objects_) {
    if (object.until > now || object.phase == Phase::none || object.phase == Phase::in_controller) continue;
    end_job(object, JobState::timed_out);
  }
}

ObjectState MessageObjects::state(unsigned number) const noexcept {
  const Object& object = objects_[number];
  ObjectState state = object.count;
  state.configured = object.configured;
  state.settings = object.settings;
  state.place = object.phase;
  state.every_time = object.job.every_time;
  state.open = object.open;
  state.full = object.full;
  state.overrun = object.overrun;
  state.frame = object.settings.transmit ? object.job.frame : object.received.frame;
  return state;
}

Time MessageObjects::next_deadline() const noexcept {
  Time next = Time::max();
  for (const Object& object : objects_) {
    if (object.phase == Phase::ready || object.phase == Phase::waits_for_remote)
      next = std::min(next, object.until);
  }
  return next;
}

}  // namespace layer2
