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

ObjectProblem MessageObjects::configure(unsigned number, const ObjectSettings& settings) noexcept {
  if (number >= kMost) return ObjectProblem::number;
  Object& object = objects_[number];
  if (object.reserved) return ObjectProblem::reserved;
  if (settings.rule.identifier > largest(settings.rule.extended)) return ObjectProblem::frame;
  const bool had_job = object.phase != Phase::idle;
  object = {};
  object.settings = settings;
  object.configured = true;
  if (had_job && settings.transmit) object.told = JobState::aborted;
  return ObjectProblem::none;
}

void MessageObjects::reserve(unsigned number) noexcept {
  if (number >= kMost) return;
  objects_[number] = {};
  objects_[number].reserved = true;
}

void MessageObjects::reset() noexcept {
  for (Object& object : objects_) {
    const bool reserved = object.reserved;
    object = {};
    object.reserved = reserved;
  }
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
  const bool replaceable = object.phase == Phase::idle || object.phase == Phase::waits_for_remote;
  if (!replaceable) return ObjectProblem::pending;
  object.job = job;
  object.phase = job.on_remote ? Phase::waits_for_remote : Phase::ready;
  object.told = JobState::none;
  object.asked_again = false;
  object.until = object.settings.timeout > Time{0} ? now + object.settings.timeout : Time::max();
  return ObjectProblem::none;
}

bool MessageObjects::abort(unsigned number) noexcept {
  if (number >= kMost) return false;
  Object& object = objects_[number];
  if (object.phase == Phase::idle || object.phase == Phase::in_controller) return false;
  object.phase = Phase::idle;
  object.told = JobState::aborted;
  object.until = Time::max();
  return true;
}

JobState MessageObjects::take_state(unsigned number) noexcept {
  if (number >= kMost) return JobState::none;
  Object& object = objects_[number];
  const JobState told = object.told;
  object.told = JobState::none;
  if (told != JobState::none) return told;
  return object.phase == Phase::idle ? JobState::none : JobState::under_way;
}

std::optional<unsigned> MessageObjects::next() const noexcept {
  for (unsigned number = 0; number < kMost; ++number) {
    if (objects_[number].phase == Phase::ready) return number;
  }
  return std::nullopt;
}

void MessageObjects::handed_over(unsigned number) noexcept {
  if (number < kMost && objects_[number].phase == Phase::ready) objects_[number].phase = Phase::in_controller;
}

void MessageObjects::sent(unsigned number) noexcept {
  if (number >= kMost || objects_[number].phase != Phase::in_controller) return;
  Object& object = objects_[number];
  if (object.request) {  // the remote frame of an object that receives
    object.request = false;
    object.phase = Phase::idle;
    return;
  }
  object.told = JobState::done;
  object.until = Time::max();
  object.phase = Phase::idle;
  if (!object.job.on_remote || !object.job.every_time) return;
  object.phase = object.asked_again ? Phase::ready : Phase::waits_for_remote;
  object.asked_again = false;
}

void MessageObjects::controller_emptied() noexcept {
  for (Object& object : objects_) {
    if (object.phase != Phase::in_controller) continue;
    object.phase = object.job.every_time && !object.request ? Phase::waits_for_remote : Phase::idle;
    object.until = Time::max();
    if (!object.request) object.told = JobState::timed_out;
    object.request = false;
  }
}

ObjectProblem MessageObjects::release(unsigned number, bool request) noexcept {
  if (const ObjectProblem problem = access(number, false); problem != ObjectProblem::none) return problem;
  Object& object = objects_[number];
  object.open = true;
  if (!request) return ObjectProblem::none;
  if (object.phase != Phase::idle) return ObjectProblem::pending;
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
      object.phase = Phase::ready;
      return;
    }
    if (object.job.every_time && object.phase == Phase::in_controller) {
      object.asked_again = true;
      return;
    }
  }
}

std::optional<unsigned> MessageObjects::receive(const can::Frame& frame) noexcept {
  if (frame.remote && !frame.error) answer_remote(frame);
  if (frame.remote) return std::nullopt;
  for (unsigned number = 0; number < kMost; ++number) {
    Object& object = objects_[number];
    if (!object.configured || object.settings.transmit || !takes(object.settings.rule, frame)) continue;
    if (object.full) {
      object.overrun = true;
      continue;
    }
    if (!object.open) continue;
    object.open = false;
    object.full = true;
    object.received = frame;
    return number;
  }
  return std::nullopt;
}

std::optional<ObjectReading> MessageObjects::read(unsigned number, bool release_anew) noexcept {
  if (number >= kMost || !objects_[number].full) return std::nullopt;
  Object& object = objects_[number];
  const ObjectReading reading{object.received, object.overrun};
  object.full = false;
  object.overrun = false;
  object.open = release_anew;
  return reading;
}

void MessageObjects::advance(Time now) noexcept {
  for (Object& object : objects_) {
    if (object.until > now || object.phase == Phase::idle || object.phase == Phase::in_controller) continue;
    object.phase = Phase::idle;
    object.told = JobState::timed_out;
    object.until = Time::max();
  }
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
