#include "daemon/desk/gateway_events.h"

#include <fmt/format.h>

#include "dds/bounded_text.h"

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

bool FloodGuard::pass(const EventText& event, SteadyTime now) {
  // Requests of all slaves together, so that a program that writes all the time leaves room for faults.
  Window& window = windows_[{event.code, event.request ? -1 : event.slave}];
  // A window with something held back stays open until its summary was told.
  if (window.held_back == 0 && now - window.begin >= kWindow) {
    window.begin = now;
    window.told = 0;
  }
  if (window.told < kBurst) {
    ++window.told;
    return true;
  }
  ++window.held_back;
  window.newest = event;
  return false;
}

std::optional<EventText> FloodGuard::due(SteadyTime now) {
  for (auto& [kind, window] : windows_) {
    if (window.held_back == 0 || now - window.begin < kWindow) continue;
    EventText summary = std::move(*window.newest);
    summary.text += fmt::format(" (the last of {} within a second that were not told)", window.held_back);
    // The summary is the first of the next second.
    window = {now, 1, 0, std::nullopt};
    return summary;
  }
  return std::nullopt;
}

std::optional<SteadyTime> FloodGuard::next() const {
  std::optional<SteadyTime> earliest;
  for (const auto& [kind, window] : windows_) {
    if (window.held_back == 0) continue;
    if (!earliest || window.begin + kWindow < *earliest) earliest = window.begin + kWindow;
  }
  return earliest;
}

bool EventPublisher::publish(const EventText& event, SteadyTime now) {
  if (!guard_.pass(event, now)) return false;
  write(event);
  return true;
}

std::optional<SteadyTime> EventPublisher::tick(SteadyTime now) {
  while (const auto summary = guard_.due(now)) write(*summary);
  return guard_.next();
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
