#include "daemon/desk/gateway_events.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "dds/bounded_text.h"
#include "text/counts.h"

namespace cansyncd {
namespace {

LogPriority priority_of(gateway_EventSeverity severity) noexcept {
  switch (severity) {
    case gateway_SEVERITY_WARNING:
      return LogPriority::warning;
    case gateway_SEVERITY_ERROR:
      return LogPriority::error;
    case gateway_SEVERITY_INFO:
      break;
  }
  return LogPriority::info;
}

}  // namespace

std::int64_t wall_clock_now() noexcept {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

void FloodGuard::Window::refill(SteadyTime now) {
  if (left == kMost) refilled = now;
  const auto rises = (now - refilled) / kRefill;
  refilled += rises * kRefill;
  left = static_cast<unsigned>(std::min<std::int64_t>(kMost, left + rises));
}

void FloodGuard::Window::count_told(const EventText& event) {
  ++told;
  if (!event.request && left != 0) --left;
}

bool FloodGuard::Window::is_due(SteadyTime now) {
  refill(now);
  return held_back != 0 && left != 0 && now - begin >= kWindow;
}

EventText FloodGuard::Window::summary(SteadyTime now) {
  EventText out = *std::exchange(newest, std::nullopt);
  out.text += fmt::format(" (the last of {} within {} that were not told)", std::exchange(held_back, 0),
                          text::duration_text(std::chrono::ceil<std::chrono::seconds>(now - held_since)));
  // It is the first of the next second.
  begin = now;
  told = 0;
  count_told(out);
  return out;
}

bool FloodGuard::pass(const EventText& event, SteadyTime now) {
  // Requests of all slaves together, so that a program that writes all the time leaves room for faults.
  Window& window = windows_[{event.code, event.request ? -1 : event.slave}];
  // A window with something held back stays open until its summary was told.
  if (window.held_back == 0 && now - window.begin >= kWindow) {
    window.begin = now;
    window.told = 0;
  }
  window.refill(now);
  if (window.held_back == 0 && window.told < kBurst && window.left != 0) {
    window.count_told(event);
    return true;
  }
  if (window.held_back++ == 0) window.held_since = now;
  window.held_last = now;
  window.newest = event;
  return false;
}

std::optional<EventText> FloodGuard::held_of(int slave, SteadyTime now) {
  Window* first = nullptr;
  for (auto& [kind, window] : windows_) {
    // Requests say nothing of how a slave is.
    if (kind.second != slave || window.held_back == 0 || window.newest->request) continue;
    if (first == nullptr || window.held_last < first->held_last) first = &window;
  }
  return first != nullptr ? std::optional(first->summary(now)) : std::nullopt;
}

std::optional<EventText> FloodGuard::due(SteadyTime now) {
  for (auto& [kind, window] : windows_) {
    if (!window.is_due(now)) continue;
    return window.newest->request ? window.summary(now) : held_of(kind.second, now);
  }
  return std::nullopt;
}

std::optional<EventText> FloodGuard::left(SteadyTime now) {
  for (auto& [kind, window] : windows_) {
    if (window.held_back == 0) continue;
    return window.newest->request ? window.summary(now) : held_of(kind.second, now);
  }
  return std::nullopt;
}

std::optional<SteadyTime> FloodGuard::next() const {
  std::optional<SteadyTime> earliest;
  for (const auto& [kind, window] : windows_) {
    if (window.held_back == 0) continue;
    SteadyTime at = window.begin + kWindow;
    if (window.left == 0) at = std::max(at, window.refilled + kRefill);
    if (!earliest || at < *earliest) earliest = at;
  }
  return earliest;
}

bool EventPublisher::publish(const EventText& event, SteadyTime now) {
  if (!guard_.pass(event, now)) return false;
  while (!event.request) {
    const auto before = guard_.held_of(event.slave, now);
    if (!before) break;
    write(*before);
  }
  write(event);
  return true;
}

std::optional<SteadyTime> EventPublisher::tick(SteadyTime now) {
  while (const auto summary = guard_.due(now)) write(*summary);
  return guard_.next();
}

void EventPublisher::finish(SteadyTime now) {
  while (const auto summary = guard_.left(now)) write(*summary);
}

void EventPublisher::write(const EventText& event) {
  gateway_Event sample = {};
  sample.number = ++number_;
  sample.time = event.when ? event.when->wall_clock.count() : wall_clock_now();
  sample.interval = event.when ? event.when->interval : interval_;
  sample.severity = event.severity;
  gateway::dds::copy_text(event.code, sample.code);
  sample.slave = event.slave;
  gateway::dds::copy_text(event.text, sample.text);
  gateway::dds::copy_text(event.participant, sample.participant);
  if (event.request) {
    gateway::dds::copy_text(event.request->client, sample.client);
    gateway::dds::copy_text(event.request->participant, sample.participant);
    gateway::dds::copy_text(event.request->action, sample.action);
    gateway::dds::copy_text(event.request->old_value, sample.old_value);
    gateway::dds::copy_text(event.request->new_value, sample.new_value);
    gateway::dds::copy_text(event.request->result, sample.result);
  }
  // Keep last: a reader that does not follow loses the oldest, the write itself cannot fail for want of room.
  const dds_return_t written = writers_.at(sample.severity).write(sample);
  // A request of a client has its entry in the journal already.
  if (!event.request) {
    std::vector<JournalField> fields = fields_of(event);
    fields.push_back({"CANSYNC_EVENT_NUMBER", std::to_string(sample.number)});
    journal_.write(priority_of(event.severity), event.code,
                   fmt::format("event {} {}: {}", sample.number, event.code.word(), event.text), fields);
  }
  if (written != DDS_RETCODE_OK) {
    journal_.write(LogPriority::warning, "event_not_published",
                   fmt::format("event {} was not published: {}", sample.number, dds_strretcode(written)),
                   {{"BUS", bus_}, {"CANSYNC_EVENT_NUMBER", std::to_string(sample.number)}});
  }
}

void EventPublisher::record(const EventText& event) {
  journal_.write(LogPriority::notice, event.code, event.text, fields_of(event));
}

std::vector<JournalField> EventPublisher::fields_of(const EventText& event) const {
  const std::uint64_t interval = event.when ? event.when->interval : interval_;
  return {{"BUS", bus_},
          {"SLAVE", event.slave >= 0 ? std::to_string(event.slave) : std::string()},
          {"PARAMETER", event.parameter >= 0 ? std::to_string(event.parameter) : std::string()},
          {"CLIENT", event.client},
          {"CANSYNC_INTERVAL", std::to_string(interval)}};
}

}  // namespace cansyncd
