#include "cli/layer2/control_verbs.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cli/connect/bus_connection.h"
#include "cli/connect/gateway_reply.h"
#include "cli/layer2/frame_lines.h"
#include "cli/text/column_help.h"
#include "cli/text/values.h"
#include "layer2/client/frame_client.h"

namespace cansync::cli {
namespace {

/// One thing that `can` does.
struct CanAction {
  std::string_view word;
  layer2_ControlKind kind;
  bool numbered;  ///< of a timer
  std::string_view done;
};

constexpr auto kCanActions = std::to_array<CanAction>({
    {"run", layer2_CONTROL_RUN, false, "runs"},
    {"stop", layer2_CONTROL_STOP, false, "is in stop"},
    {"start-timer", layer2_CONTROL_START_TIMER, true, "started"},
    {"stop-timer", layer2_CONTROL_STOP_TIMER, true, "stopped"},
    {"clear-queues", layer2_CONTROL_CLEAR_QUEUES, false, "queues emptied"},
    {"reset-overflow", layer2_CONTROL_RESET_OVERFLOW, false, "overflow bits reset"},
    {"reset-controller", layer2_CONTROL_RESET_CONTROLLER, false, "controller reset"},
});

std::string can_words() {
  std::string words;
  for (const CanAction& action : kCanActions)
    words += fmt::format("{}{}", words.empty() ? "" : ", ", action.word);
  return words;
}

ExitCode can_verb(Session& session, const std::string& word, const std::string& number_text) {
  const auto found = std::find_if(kCanActions.begin(), kCanActions.end(),
                                  [&](const CanAction& action) { return action.word == word; });
  if (found == kCanActions.end())
    throw UsageError(fmt::format("ACTION: found '{}'; allowed: {}", word, can_words()));
  const CanAction& action = *found;
  if (!action.numbered && !number_text.empty())
    throw UsageError("NUMBER: only with start-timer and stop-timer");
  layer2_ControlRequest request = {};
  request.kind = action.kind;
  if (action.numbered)
    request.number = static_cast<std::uint8_t>(parse_integer(number_text, "NUMBER", 1, 16));
  layer2::client::FrameClient client = connect_bus<layer2::client::FrameClient>(session);
  const layer2::client::SendResult result = client.control(request);
  JsonObject object;
  object.add("action", action.word).add("number", request.number);
  const std::string where = action.numbered ? fmt::format("timer {}", request.number) : std::string("module");
  return session.finish(reply_of(result), object, where, fmt::format("{}: {}", where, action.done));
}

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
    if (session.output().json()) {
      JsonObject object;
      object.add("number", timer.number).add("running", timer.running);
      add_frame(timer.content, object);
      object.add("period_us", timer.period)
          .add("phase_us", timer.phase)
          .add("cyclic", timer.cyclic)
          .add("sent", timer.sent)
          .add("left_out", timer.left_out);
      session.output().object(object);
      continue;
    }
    session.output().line(table.line({fmt::format("{}", timer.number), timer.running ? "running" : "stopped",
                                      identifier_text(timer.content), data_text(timer.content),
                                      fmt::format("{}", timer.period), fmt::format("{}", timer.phase),
                                      fmt::format("{}", timer.sent), fmt::format("{}", timer.left_out)}));
  }
  return ExitCode::done;
}

}  // namespace

void add_control_verbs(CLI::App& app, Verb& chosen) {
  auto* can = app.add_subcommand("can", "general frames: run, stop, timers, queues, controller");
  auto action = std::make_shared<std::string>();
  auto number = std::make_shared<std::string>();
  can->add_option("ACTION", *action, "what is to be done: " + can_words())->required();
  can->add_option("NUMBER", *number, "of the timer, 1..16");
  can->footer(
      "Of a bus with bus.protocol = \"layer2\". In stop nothing is sent or received but what the script of stop starts.");
  can->callback([action, number, &chosen] {
    chosen = [action, number](Session& session) { return can_verb(session, *action, *number); };
  });
  auto* timers = app.add_subcommand("timers", "general frames: the timers that are set up");
  timers->footer("Of a bus with bus.protocol = \"layer2\".\n" + columns_help(timer_columns()));
  timers->callback([&chosen] { chosen = timers_verb; });
}

}  // namespace cansync::cli
