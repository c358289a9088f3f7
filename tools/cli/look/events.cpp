#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <deque>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <tuple>

#include "cli/base/interrupt.h"
#include "cli/base/restarts.h"
#include "cli/base/verb_groups.h"
#include "cli/look/event_filter.h"
#include "cli/look/verbs.h"
#include "cli/text/column_help.h"
#include "text/counts.h"
#include "text/visible.h"

namespace cansync::cli {
namespace {

constexpr auto kLook = std::chrono::milliseconds(50);

/// The arguments as they were typed; empty: not given.
struct EventTexts {
  bool following = false;
  std::string since;
  std::string level;
  std::string codes;
  std::string slaves;
};

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

Style event_style(gateway_EventSeverity severity) {
  if (severity == gateway_SEVERITY_ERROR) return Style::bad;
  return severity == gateway_SEVERITY_WARNING ? Style::warning : Style::plain;
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
  output_.line(
      output_.painted(table_.line({time_text(event.time, true), std::string(severity_name(event.severity)),
                                   event.code, text::visible(event.text)}),
                      event_style(event.severity)));
}

/// Events on their way from the client's thread to this one. While nobody takes them, as when a pager stands still, the
/// newest are kept.
class EventQueue {
 public:
  static constexpr std::size_t kMost = 10000;

  void put(const client::Event& event) {
    const std::lock_guard lock(mutex_);
    if (events_.size() == kMost) {
      events_.pop_front();
      ++dropped_;
    }
    events_.push_back(event);
  }
  /// Those that were dropped since the last call.
  std::uint64_t take_dropped() {
    const std::lock_guard lock(mutex_);
    return std::exchange(dropped_, 0);
  }
  std::deque<client::Event> take_all() {
    const std::lock_guard lock(mutex_);
    return std::exchange(events_, {});
  }

 private:
  std::mutex mutex_;
  std::deque<client::Event> events_;
  std::uint64_t dropped_ = 0;
};

ExitCode follow(Session& session, EventFilter filter, const std::string& slaves) {
  client::Client& client = session.client();
  EventQueue queue;
  EventLines lines(session.output());
  Restarts restarts(client);
  const auto subscription = client.on_event([&queue](const client::Event& event) { queue.put(event); });
  for (;;) {
    const bool stop = wait_until(std::chrono::steady_clock::now() + kLook);
    if (restarts.take()) session.output().remark(kStartedAnew);
    restarts.expect_one();
    if (!slaves.empty() && !restarts.gone())
      (void)session.follow_names([&] { filter.slaves = session.slave_mask(slaves); });
    if (const std::uint64_t dropped = queue.take_dropped(); dropped != 0)
      session.output().remark(
          fmt::format("{} left out: they came faster than they were read", text::counted(dropped, "event")));
    auto events = queue.take_all();
    // Those of before come level by level.
    std::sort(events.begin(), events.end(), [](const client::Event& one, const client::Event& other) {
      return std::tie(one.time, one.number) < std::tie(other.time, other.number);
    });
    for (const client::Event& event : events)
      if (passes(filter, event)) lines.show(event);
    if (stop) return ExitCode::done;
    if (restarts.gone()) {
      session.output().remark("the daemon has gone (" + client.place() + ")");
      return ExitCode::not_reachable;
    }
  }
}

/// Slaves are looked up last: what else is wrong is told without a daemon.
EventFilter event_filter(Session& session, const EventTexts& texts) {
  EventFilter filter;
  if (!texts.since.empty()) {
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    filter.since = parse_since(texts.since, std::chrono::nanoseconds(now).count());
  }
  if (!texts.level.empty()) filter.least = parse_severity(texts.level);
  if (!texts.codes.empty()) filter.codes = parse_codes(texts.codes);
  if (!texts.slaves.empty()) filter.slaves = session.slave_mask(texts.slaves);
  return filter;
}

/// A code that is misspelt passes nothing, which must not look as if nothing had happened.
void tell_none_passes(Output& output, const std::vector<client::Event>& events) {
  std::set<std::string> codes;
  for (const client::Event& event : events) codes.emplace(event.code);
  std::string list;
  for (const std::string& code : codes) list += (list.empty() ? "" : ", ") + code;
  output.remark(fmt::format("none of the {} the daemon keeps is one of these; their codes: {}",
                            text::counted(events.size(), "event"), list));
}

ExitCode events_verb(Session& session, const EventTexts& texts) {
  session.look_only();
  const EventFilter filter = event_filter(session, texts);
  if (texts.following) return follow(session, filter, texts.slaves);
  EventLines lines(session.output());
  const std::vector<client::Event> events = session.client().recent_events();
  bool any = false;
  for (const client::Event& event : events) {
    if (!passes(filter, event)) continue;
    lines.show(event);
    any = true;
  }
  if (!any && !events.empty()) tell_none_passes(session.output(), events);
  return ExitCode::done;
}

}  // namespace

void add_event_verb(CLI::App& app, Verb& chosen) {
  auto* events =
      app.add_subcommand("events", "what happened: the last 100 events of each level, oldest first");
  events->group(kLookingVerbs);
  auto texts = std::make_shared<EventTexts>();
  events->add_flag("--follow", texts->following, "then also those to come, until Ctrl-C");
  events
      ->add_option(
          "--since", texts->since,
          "only since then: how long ago (90s, 10m, 2h, 1d), a time of day (14:05), or a date with or "
          "without one ('2026-11-23 14:05')")
      ->type_name("TIME");
  events->add_option("--level", texts->level, "only of this level, or graver")
      ->type_name("info|warning|error");
  events->add_option("--code", texts->codes, "only of these codes, with commas between")->type_name("CODES");
  events
      ->add_option("--slave", texts->slaves,
                   "only what concerns one of these slaves: a list such as 1,3,5-9, or all")
      ->type_name("SLAVE");
  events->footer(columns_help(event_columns()));
  events->callback(
      [texts, &chosen] { chosen = [texts](Session& session) { return events_verb(session, *texts); }; });
}

}  // namespace cansync::cli
