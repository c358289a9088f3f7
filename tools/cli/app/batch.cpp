#include "cli/app/batch.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>

#include "cli/app/batch_source.h"
#include "cli/app/batch_words.h"
#include "cli/app/command_line.h"
#include "cli/base/endings.h"
#include "cli/base/interrupt.h"
#include "cli/base/left_out.h"
#include "cli/base/verb_groups.h"
#include "cli/look/expect_value.h"
#include "cli/text/words.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

/// The arguments as they were typed.
struct BatchTexts {
  std::string file;
  std::vector<std::string> variables;
  bool go_on = false;
};

/// Verbs whose arguments are looked at before the first line runs: these do nothing before they ask for the
/// daemon.
constexpr std::array<std::string_view, 16> kChecked = {
    "read", "write", "params",   "control", "broadcast", "mode",   "release", "set",
    "poll", "map",   "download", "backup",  "restore",   "verify", "slaves",  "wait"};

constexpr std::string_view kExpectedValues =
    "value SLAVE VALUE COMPARISON NUMBER [within SECONDS], read SLAVE PARAMETER COMPARISON NUMBER [within "
    "SECONDS]";

/// A line that is ready to run.
struct Line {
  std::size_t number = 0;
  Command command;
};

/// What an error says it found; empty when it says nothing.
std::string_view found_in(std::string_view complaint) {
  constexpr std::string_view kFound = "found '";
  const auto start = complaint.find(kFound);
  if (start == std::string_view::npos) return {};
  const std::string_view rest = complaint.substr(start + kFound.size());
  return rest.substr(0, rest.find('\''));
}

/// Column of the word that an error speaks of; of the first one when that is not to be seen.
std::size_t column_of(const std::vector<Word>& words, std::string_view complaint) {
  const std::string_view found = found_in(complaint);
  // The last word first: the verb stands before what is wrong with it.
  const auto last = [&words](const auto& fits) {
    const auto word = std::find_if(words.rbegin(), words.rend(), fits);
    return word == words.rend() ? std::size_t{0} : word->column;
  };
  if (const auto column = last([&](const Word& word) { return word.text == found; })) return column;
  const auto part = [&](const Word& word) {
    return !found.empty() && word.text.find(found) != std::string::npos;
  };
  if (const auto column = last(part)) return column;
  const auto named = [&](const Word& word) {
    if (complaint.ends_with(" " + word.text)) return true;
    return word.text.size() > 1 && complaint.find(word.text) != std::string_view::npos;
  };
  if (const auto column = last(named)) return column;
  return words.front().column;
}

/// One run of the verb.
class Batch {
 public:
  Batch(Session& session, const BatchTexts& texts)
      : session_(session),
        name_(texts.file == "-" ? "standard input" : texts.file),
        go_on_(texts.go_on),
        globals_(session.globals()) {
    for (const std::string& word : texts.variables)
      if (!variables_.take(word))
        throw UsageError(
            fmt::format("NAME=VALUE: found '{}'; allowed: letters, digits and '_', '=', a value", word));
  }

  /// Reads all lines, then runs them.
  ExitCode run_file(const std::string& path) {
    std::vector<Line> lines;
    BatchSource source(path);
    std::size_t wrong = 0;
    while (const auto text = source.next()) {
      try {
        if (auto line = parse(*text, source.number())) lines.push_back(std::move(*line));
      } catch (const UsageError& error) {
        session_.output().remark(error.what());
        ++wrong;
      }
    }
    if (interrupt_flag().load()) throw Interrupted();
    if (wrong > 0)
      throw UsageError(fmt::format("{}: {} wrong; nothing was sent", name_,
                                   wrong == 1 ? "a line is" : text::counted(wrong, "line is", "lines are")));
    for (const Line& line : lines)
      if (!go(line)) break;
    return end();
  }

  /// Runs each line as it comes.
  ExitCode run_input() {
    globals_.input_is_taken = true;
    BatchSource source("-");
    while (!interrupt_flag().load()) {
      const auto text = source.next();
      if (!text) break;
      try {
        const auto line = parse(*text, source.number());
        if (line && !go(*line)) break;
      } catch (const UsageError& error) {
        session_.output().remark(error.what());
        if (!ended(source.number(), "", ExitCode::usage, error.what())) break;
      }
    }
    return end();
  }

 private:
  /// The command of a line; nothing when it has none. Throws UsageError with the place.
  std::optional<Line> parse(std::string_view text, std::size_t number) {
    std::vector<Word> words;
    try {
      words = split_words(text);
      if (words.empty()) return std::nullopt;
      if (words.size() == 1 && variables_.take(words.front().text)) return std::nullopt;
      std::vector<std::string> texts;
      texts.reserve(words.size());
      for (Word& word : words) texts.push_back(word.text = variables_.expand(word.text));
      Line line{number, command_of(texts)};
      check(line.command);
      return line;
    } catch (const WordError& error) {
      throw UsageError(fmt::format("{}:{}:{}: {}", name_, number, error.column(), error.what()));
    } catch (const UsageError& error) {
      const std::string_view all = error.what();
      const std::string_view first = all.substr(0, all.find('\n'));
      throw UsageError(fmt::format("{}:{}:{}: {}", name_, number, column_of(words, first), first));
    }
  }

  /// What these words stand for: a verb, or what a batch alone knows. Throws UsageError.
  Command command_of(std::vector<std::string> words) const {
    if (words.front() == "sleep") {
      words.erase(words.begin());
      return {globals_, "sleep", sleep_verb(words)};
    }
    if (words.front() == "expect") {
      const std::string status = words.size() > 1 ? words[1] : "";
      if (status == "value" || status == "read") {
        words.erase(words.begin());
        return {globals_, "expect", expect_value_verb(std::move(words))};
      }
      if (!looks_like_number(status) || words.size() == 2)
        throw UsageError(fmt::format("expect: found {}; allowed: STATUS COMMAND..., {}",
                                     status.empty() ? "nothing" : "'" + status + "'", kExpectedValues));
      words.erase(words.begin(), words.begin() + 2);
      Command command = command_of(std::move(words));
      check(command);
      command.verb = expect_verb(status, std::move(command.verb));
      command.name = "expect";
      return command;
    }
    Command command = parse_batch_command(words, globals_);
    if (command.name == "batch") throw UsageError("found 'batch'; allowed in a batch: every other verb");
    return command;
  }

  /// Looks at the arguments that can be understood without a daemon. Throws UsageError.
  void check(const Command& command) const {
    if (std::find(kChecked.begin(), kChecked.end(), command.name) == kChecked.end()) return;
    Output output = session_.output().for_line(command.globals.json, "");
    Session session(command.globals, output, session_.connection(), Purpose::check);
    try {
      static_cast<void>(command.verb(session));
    } catch (const ArgumentsAreRight&) {
      return;
    }
  }

  /// Runs a line. False when the batch ends with it.
  bool go(const Line& line) {
    if (interrupt_flag().load()) return false;
    Output output =
        session_.output().for_line(line.command.globals.json, fmt::format("{}:{}: ", name_, line.number));
    output.set_colours(line.command.globals.colours);
    ExitCode code = ExitCode::done;
    try {
      Session session(line.command.globals, output, session_.connection());
      code = end_of_verb(line.command.verb(session));
    } catch (const std::exception& error) {
      output.remark(error.what());
      code = code_of(error);
    }
    return ended(line.number, line.command.name, code, code == ExitCode::done ? "" : output.last_remark());
  }

  /// Tells how a line ended. False when the batch ends with it.
  bool ended(std::size_t number, std::string_view verb, ExitCode code, std::string_view reason) {
    if (session_.json()) {
      session_.output().object(JsonObject()
                                   .add("file", name_)
                                   .add("line", number)
                                   .add("verb", verb)
                                   .add("exit_code", static_cast<unsigned>(code))
                                   .add("reason", reason));
    }
    if (first_ == ExitCode::done) first_ = code;
    // What was left out of a file changes nothing of what the line has done.
    return code == ExitCode::done || code == ExitCode::in_part || go_on_;
  }

  ExitCode end() const {
    return first_ == ExitCode::done && interrupt_flag().load() ? ExitCode::cancelled : first_;
  }

  Session& session_;
  std::string name_;
  bool go_on_;
  Globals globals_;
  BatchVariables variables_;
  ExitCode first_ = ExitCode::done;
};

ExitCode batch_verb(Session& session, const BatchTexts& texts) {
  Batch batch(session, texts);
  return texts.file == "-" ? batch.run_input() : batch.run_file(texts.file);
}

}  // namespace

void add_batch_verb(CLI::App& app, Verb& chosen) {
  auto* batch = app.add_subcommand("batch", "run commands from a file, one a line, over one connection");
  batch->group(kManyVerbs);
  auto texts = std::make_shared<BatchTexts>();
  batch->add_option("FILE", texts->file, "file with commands; - = standard input, each line runs as it comes")
      ->required();
  batch->add_option("NAME=VALUE", texts->variables,
                    "variables of the lines, as if they were set at their beginning");
  batch->add_flag("--continue", texts->go_on, "go on with the next line when one fails (default: stop)");
  batch->footer(
      "A line is what stands behind `cansync`: \"read winder 100\". Words may be quoted with '...' and "
      "\"...\"; # begins a\n"
      "comment; empty lines are left out. Lines may have --json, --timeout and --retry of their own; what "
      "they do not have is\nas given to batch. All lines of a file are looked at before the first one runs: "
      "when one is wrong, its line and\ncolumn are told and nothing is sent. Exit code: that of the first "
      "line that failed.\n"
      "A line NAME=VALUE sets a variable, $NAME or ${NAME} stands for it from there on, and $$ for $. `sleep SECONDS` "
      "waits.\n`expect STATUS COMMAND...` is done when the command ends with this exit status, `expect value SLAVE "
      "VALUE '>' 10`\nand `expect read SLAVE PARAMETER '>' 10` when the value is so, with `within SECONDS` when it "
      "becomes so.");
  batch->callback(
      [texts, &chosen] { chosen = [texts](Session& session) { return batch_verb(session, *texts); }; });
}

}  // namespace cansync::cli
