#include "cli/layer2/script_verb.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <string>
#include <thread>

#include "cli/base/files.h"
#include "cli/base/interrupt.h"
#include "cli/connect/bus_verb.h"
#include "cli/connect/gateway_reply.h"
#include "cli/layer2/frame_lines.h"
#include "layer2/client/frame_client.h"
#include "layer2/script.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

using layer2::ScriptCommand;
using layer2::client::FrameClient;

constexpr std::size_t kLongestScript = 65536;  // bytes

/// The arguments of `can script` as they were typed.
struct ScriptTexts {
  std::string action;
  std::string file;
  std::string numbers;
  bool extended = false;
};

layer2::ScriptRules rules_of(const ScriptTexts& texts) {
  layer2::ScriptRules rules;
  rules.extended = texts.extended;
  if (texts.numbers == "decimal")
    rules.numbers = layer2::ScriptNumbers::decimal;
  else if (texts.numbers == "hexadecimal")
    rules.numbers = layer2::ScriptNumbers::hexadecimal;
  else if (!texts.numbers.empty() && texts.numbers != "marked")
    throw UsageError(
        fmt::format("--numbers: found '{}'; allowed: marked, decimal, hexadecimal", texts.numbers));
  return rules;
}

std::string place_of(const ScriptTexts& texts) {
  return texts.file == "-" ? "standard input" : texts.file;
}

/// What is wrong with it, on standard error.
void tell_problems(Session& session, const ScriptTexts& texts, const layer2::Script& script) {
  for (const layer2::ScriptProblem& problem : script.problems)
    session.output().remark(
        fmt::format("{}:{}:{}: {}", place_of(texts), problem.line, problem.column, problem.text));
}

ExitCode check_script(Session& session, const ScriptTexts& texts, const layer2::Script& script) {
  tell_problems(session, texts, script);
  const bool good = script.problems.empty();
  if (session.json()) {
    JsonArray problems;
    for (const layer2::ScriptProblem& problem : script.problems)
      problems.add_json(JsonObject()
                            .add("line", problem.line)
                            .add("column", problem.column)
                            .add("text", problem.text)
                            .text());
    session.output().object(JsonObject()
                                .add("file", texts.file)
                                .add("commands", script.commands.size())
                                .add("problems", problems));
  } else if (good) {
    session.output().remark(
        fmt::format("{}: {}, no errors", place_of(texts), text::counted(script.commands.size(), "command")));
  }
  return good ? ExitCode::done : ExitCode::failed;
}

/// Waits; true at Ctrl-C.
bool wait_in_script(std::chrono::milliseconds time) {
  constexpr auto kLook = std::chrono::milliseconds(50);
  const auto end = std::chrono::steady_clock::now() + time;
  for (auto now = std::chrono::steady_clock::now(); now < end && !interrupt_flag().load();
       now = std::chrono::steady_clock::now())
    std::this_thread::sleep_until(std::min<std::chrono::steady_clock::time_point>(end, now + kLook));
  return interrupt_flag().load();
}

/// Does one command, which is no `wait`, and tells how it ended.
ExitCode run_command(Session& session, FrameClient& client, const ScriptCommand& command,
                     std::size_t number) {
  JsonObject object;
  object.add("command", number);
  if (command.kind == ScriptCommand::Kind::send) {
    const auto result = client.send(command.frame, session.monitoring_ms());
    object.add("kind", command.frame.remote ? "fetch" : "send").add("timer", 0).add("frame", [&command] {
      JsonObject frame;
      add_frame(command.frame, frame);
      return frame;
    }());
    return session.finish(reply_of(result), object,
                          fmt::format("command {}, frame {}", number, identifier_text(command.frame)));
  }
  const bool start = command.kind == ScriptCommand::Kind::start;
  layer2_ControlRequest request = {};
  request.kind = start ? layer2_CONTROL_START_TIMER : layer2_CONTROL_STOP_TIMER;
  request.number = static_cast<std::uint8_t>(command.number);
  const auto result = client.control(request);
  object.add("kind", start ? "start" : "stop").add("timer", command.number).add_null("frame");
  return session.finish(reply_of(result), object,
                        fmt::format("command {}, timer {}", number, command.number));
}

ExitCode run_script(Session& session, const layer2::Script& script) {
  auto client = connect_bus<FrameClient>(session);
  (void)client.status(session.search_time());
  std::size_t number = 0;
  for (const ScriptCommand& command : script.commands) {
    ++number;
    if (interrupt_flag().load()) return ExitCode::cancelled;
    if (command.kind == ScriptCommand::Kind::wait) {
      if (wait_in_script(std::chrono::milliseconds(command.number))) return ExitCode::cancelled;
    } else if (const ExitCode code = run_command(session, client, command, number); code != ExitCode::done) {
      return code;
    }
  }
  if (!session.json()) session.output().remark(text::counted(number, "command") + " done");
  return ExitCode::done;
}

ExitCode script_verb(Session& session, const ScriptTexts& texts) {
  const bool run = texts.action == "run";
  if (!run && texts.action != "check")
    throw UsageError(fmt::format("ACTION: found '{}'; allowed: check, run", texts.action));
  const layer2::ScriptRules rules = rules_of(texts);
  session.expect_input(texts.file);
  const auto bytes = read_file(texts.file, kLongestScript);
  const layer2::Script script =
      layer2::parse_script({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, rules);
  if (!run) return check_script(session, texts, script);
  if (script.problems.empty()) return run_script(session, script);
  tell_problems(session, texts, script);
  throw UsageError(place_of(texts) + ": the script has errors; nothing was sent");
}

}  // namespace

void add_script_verb(CLI::App& can, Verb& chosen) {
  auto* script = can.add_subcommand("script", "check a script, or do what it says");
  auto texts = std::make_shared<ScriptTexts>();
  script
      ->add_option("ACTION", texts->action,
                   "check: say what is wrong with it; run: do what it says, from here")
      ->required()
      ->type_name("check|run");
  script->add_option("FILE", texts->file, "the script; - = standard input")->required();
  script
      ->add_option("--numbers", texts->numbers,
                   "what numbers without 0x are, as script.numbers of the configuration (default marked)")
      ->type_name("marked|decimal|hexadecimal");
  script->add_flag("--extended", texts->extended, "identifiers have 29 bits; without: 11");
  script->footer(
      "Of a bus with bus.protocol = \"layer2\"; `check` needs no daemon. Commands: Send ID LENGTH BYTE..., Fetch ID "
      "[LENGTH],\nStart TIMER, Stop TIMER, Wait MILLISECONDS; // begins a comment. Each line of a script that runs "
      "begins when the\none before it has ended; the first that fails is the last.");
  run_when_named(*script, chosen, texts, script_verb);
}

}  // namespace cansync::cli
