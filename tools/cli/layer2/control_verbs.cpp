#include "cli/layer2/control_verbs.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <string_view>

#include "cli/connect/bus_connection.h"
#include "cli/connect/gateway_reply.h"
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

std::string can_words(std::string_view between = ", ") {
  std::string words;
  for (const CanAction& action : kCanActions)
    words += fmt::format("{}{}", words.empty() ? "" : between, action.word);
  return words;
}

ExitCode can_verb(Session& session, const std::string& word, const std::string& number_text) {
  const auto found = std::find_if(kCanActions.begin(), kCanActions.end(),
                                  [&](const CanAction& action) { return action.word == word; });
  if (found == kCanActions.end())
    throw UsageError(fmt::format("ACTION: found {}; allowed: {}, or one of the verbs of `cansync can --help`",
                                 word.empty() ? "nothing" : "'" + word + "'", can_words()));
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

}  // namespace

CLI::App& add_can_verb(CLI::App& app, Verb& chosen) {
  auto* can = app.add_subcommand("can", "general frames: watch, send, timers, queues, controller");
  can->group("General frames");
  auto action = std::make_shared<std::string>();
  auto number = std::make_shared<std::string>();
  can->add_option("ACTION", *action, "what is to be done: " + can_words())->type_name(can_words("|"));
  can->add_option("NUMBER", *number, "of the timer, 1..16");
  can->footer(
      "Of a bus with bus.protocol = \"layer2\". In stop nothing is sent or received but what the script of stop starts.");
  can->callback([can, action, number, &chosen] {
    const bool other = !can->get_subcommands().empty();
    if (other && !action->empty())
      throw UsageError(fmt::format("found '{}', which is no argument of can {}", *action,
                                   can->get_subcommands().front()->get_name()));
    if (!other) chosen = [action, number](Session& session) { return can_verb(session, *action, *number); };
  });
  return *can;
}

}  // namespace cansync::cli
