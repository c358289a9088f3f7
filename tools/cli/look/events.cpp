#include <fmt/format.h>

#include <deque>
#include <memory>
#include <mutex>

#include "cli/base/interrupt.h"
#include "cli/base/restarts.h"
#include "cli/look/verbs.h"
#include "cli/text/column_help.h"

namespace cansync::cli {
namespace {

constexpr auto kLook = std::chrono::milliseconds(50);

std::string_view severity_name(gateway_EventSeverity severity) {
  switch (severity) {
    case gateway_SEVERITY_INFO:
      return "info";
    case gateway_SEVERITY_WARNING:
      return "warning";
    case gateway_SEVERITY_ERROR:
      return "error";
    default:
      return "unknown";
  }
}

std::vector<Table::Column> event_columns() {
  constexpr auto left = Table::Align::left;
  constexpr std::size_t kTime = 23;
  constexpr std::size_t kLongestSeverity = 7;  // "warning"
  constexpr std::size_t kMostCodes = 24;
  return {{"TIME", left, "date and time, in the time zone of this computer", kTime},
          {"LEVEL", left, "severity: info, warning or error", kLongestSeverity},
          {"CODE", left, "what kind of event, a stable word such as slave_lost", kMostCodes},
          {"WHAT", left, "what happened, in words"}};
}

/// Writes events, the first one under the heading.
class EventLines {
 public:
  explicit EventLines(Output& output) : output_(output), table_(event_columns()) {}

  void show(const client::Event& event);

 private:
  Output& output_;
  Table table_;
  bool headed_ = false;
};

JsonObject event_object(const client::Event& event) {
  JsonObject object;
  object.add("number", event.number)
      .add("time_ns", event.time)
      .add("interval", event.interval)
      .add("severity", severity_name(event.severity))
      .add("code", event.code);
  if (event.slave < 0)
    object.add_null("slave");
  else
    object.add("slave", event.slave);
  object.add("text", event.text);
  const bool of_request = !std::string_view(event.action).empty();
  if (!of_request && std::string_view(event.participant).empty()) return object;
  object.add("client", event.client).add("participant", event.participant);
  if (!of_request) return object;
  return object.add("action", event.action)
      .add("old_value", event.old_value)
      .add("new_value", event.new_value)
      .add("result", event.result);
}

void EventLines::show(const client::Event& event) {
  if (output_.json()) return output_.object(event_object(event));
  if (!headed_) output_.line(table_.heading());
  headed_ = true;
  output_.line(table_.line(
      {time_text(event.time, true), std::string(severity_name(event.severity)), event.code, event.text}));
}

/// Events on their way from the client's thread to this one.
class EventQueue {
 public:
  void put(const client::Event& event) {
    const std::lock_guard lock(mutex_);
    events_.push_back(event);
  }
  std::deque<client::Event> take_all() {
    const std::lock_guard lock(mutex_);
    return std::exchange(events_, {});
  }

 private:
  std::mutex mutex_;
  std::deque<client::Event> events_;
};

ExitCode follow(Session& session) {
  client::Client& client = session.client();
  EventQueue queue;
  EventLines lines(session.output());
  Restarts restarts(client);
  const auto subscription = client.on_event([&queue](const client::Event& event) { queue.put(event); });
  for (;;) {
    const bool stop = wait_until(std::chrono::steady_clock::now() + kLook);
    if (restarts.take()) session.output().remark(kStartedAnew);
    restarts.expect_one();
    for (const client::Event& event : queue.take_all()) lines.show(event);
    if (stop) return ExitCode::done;
    if (restarts.gone()) {
      session.output().remark("the daemon has gone (" + client.place() + ")");
      return ExitCode::not_reachable;
    }
  }
}

ExitCode events_verb(Session& session, bool following) {
  session.look_only();
  if (following) return follow(session);
  EventLines lines(session.output());
  for (const client::Event& event : session.client().recent_events()) lines.show(event);
  return ExitCode::done;
}

}  // namespace

void add_event_verb(CLI::App& app, Verb& chosen) {
  auto* events = app.add_subcommand("events", "what happened: the last 100 events, oldest first");
  auto following = std::make_shared<bool>(false);
  events->add_flag("--follow", *following, "then also those to come, until Ctrl-C");
  events->footer(columns_help(event_columns()));
  events->callback([following, &chosen] {
    chosen = [following](Session& session) { return events_verb(session, *following); };
  });
}

}  // namespace cansync::cli
