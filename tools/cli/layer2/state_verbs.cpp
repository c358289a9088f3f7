#include "cli/layer2/state_verbs.h"

#include <fmt/format.h>

#include <string>
#include <vector>

#include "cli/connect/bus_verb.h"
#include "cli/layer2/frame_lines.h"
#include "cli/text/column_help.h"
#include "layer2/client/frame_client.h"
#include "layer2/dds/convert.h"

namespace cansync::cli {
namespace {

constexpr auto kOfLayer2 = "Of a bus with bus.protocol = \"layer2\".\n";

std::vector<Table::Column> timer_columns() {
  constexpr auto left = Table::Align::left;
  constexpr auto right = Table::Align::right;
  return {{"TIMER", right, "number, 1 to 16", 5},
          {"STATE", left, "running or stopped", 7},
          {"ID", right, "identifier of its frame, hexadecimal", 8},
          {"DATA", left, "the bytes, hexadecimal; remote: a frame that asks for them", 23},
          {"PERIOD", right, "between two frames, in us", 10},
          {"PHASE", right, "from its start to its first frame, in us", 10},
          {"SENT", right, "frames handed to the controller, since the start", 8},
          {"LEFT OUT", right, "frames that went by while the one before still waited", 8}};
}

ExitCode timers_verb(Session& session) {
  layer2::client::FrameClient client = connect_bus<layer2::client::FrameClient>(session);
  const auto timers = client.timers(session.search_time());
  const Table table(timer_columns());
  if (!session.output().json()) {
    session.output().line(table.heading());
    if (timers.empty()) session.output().remark("no timer is set up");
  }
  for (const layer2_TimerStatus& timer : timers) {
    const can::Frame frame = layer2::dds::to_core(timer.content);
    if (session.output().json()) {
      JsonObject object;
      object.add("number", timer.number).add("running", timer.running);
      add_frame(frame, object);
      object.add("period_us", timer.period)
          .add("phase_us", timer.phase)
          .add("cyclic", timer.cyclic)
          .add("sent", timer.sent)
          .add("left_out", timer.left_out);
      session.output().object(object);
      continue;
    }
    session.output().line(table.line({fmt::format("{}", timer.number), timer.running ? "running" : "stopped",
                                      identifier_text(frame), data_text(frame),
                                      fmt::format("{}", timer.period), fmt::format("{}", timer.phase),
                                      fmt::format("{}", timer.sent), fmt::format("{}", timer.left_out)}));
  }
  return ExitCode::done;
}

/// The queues of one direction, as the daemon told them last.
struct QueuePair {
  std::string_view name;
  std::uint32_t waiting, room;
  std::uint32_t high_waiting, high_room;
  bool overflowed;
  std::uint64_t overflows;
};

std::vector<QueuePair> queues_of(const layer2_FrameStatus& status) {
  return {{"send", status.send_waiting, status.send_depth, status.send_high_waiting, status.send_high_depth,
           status.send_overflowed, status.send_overflows},
          {"receive", status.receive_waiting, status.receive_depth, status.receive_high_waiting,
           status.receive_high_depth, status.receive_overflowed, status.receive_overflows}};
}

std::vector<Table::Column> queue_columns() {
  constexpr auto left = Table::Align::left;
  constexpr auto right = Table::Align::right;
  return {{"QUEUE", left, "send or receive", 7},
          {"WAITING", right, "frames that wait in it now", 7},
          {"ROOM", right, "frames it holds at most", 4},
          {"HIGH WAITING", right, "the same of the queue of high priority", 12},
          {"HIGH ROOM", right, "likewise", 9},
          {"OVERFLOW", left, "yes: one of the two overflowed since `can reset-overflow`", 8},
          {"LOST", right, "frames deleted or refused because one was full, since the start", 8},
          {"NOT PUBLISHED", right, "received frames that came faster than the daemon could publish", 13}};
}

ExitCode queues_verb(Session& session) {
  layer2::client::FrameClient client = connect_bus<layer2::client::FrameClient>(session);
  const auto status = expect_told(client.status(session.search_time()), "FrameStatus", client.place());
  Table table(queue_columns());
  for (const QueuePair& queue : queues_of(status)) {
    const bool receives = queue.name == "receive";
    if (session.output().json()) {
      JsonObject object;
      object.add("queue", queue.name)
          .add("waiting", queue.waiting)
          .add("room", queue.room)
          .add("high_waiting", queue.high_waiting)
          .add("high_room", queue.high_room)
          .add("overflowed", queue.overflowed)
          .add("lost", queue.overflows);
      receives ? object.add("not_published", status.lost) : object.add_null("not_published");
      session.output().object(object);
      continue;
    }
    table.add({std::string(queue.name), fmt::format("{}", queue.waiting), fmt::format("{}", queue.room),
               fmt::format("{}", queue.high_waiting), fmt::format("{}", queue.high_room),
               queue.overflowed ? "yes" : "no", fmt::format("{}", queue.overflows),
               receives ? fmt::format("{}", status.lost) : "-"});
  }
  if (!session.output().json()) session.output().table(table);
  return ExitCode::done;
}

}  // namespace

void add_timers_verb(CLI::App& can, Verb& chosen) {
  auto* timers = can.add_subcommand("timers", "the timers that are set up");
  timers->footer(kOfLayer2 + columns_help(timer_columns()));
  timers->callback([&chosen] { chosen = timers_verb; });
}

void add_queues_verb(CLI::App& can, Verb& chosen) {
  auto* queues = can.add_subcommand("queues", "what waits to be sent and to be published, and what was lost");
  queues->footer(kOfLayer2 + columns_help(queue_columns()));
  queues->callback([&chosen] { chosen = queues_verb; });
}

}  // namespace cansync::cli
