#include <fmt/format.h>

#include <ctime>
#include <memory>

#include "cli/base/interrupt.h"
#include "cli/base/restarts.h"
#include "cli/base/verb_groups.h"
#include "cli/text/column_help.h"
#include "cli/watch/parameter_turns.h"
#include "cli/watch/verbs.h"
#include "cli/watch/watch_live.h"
#include "cli/watch/watch_rows.h"
#include "cli/watch/watch_table.h"

namespace cansync::cli {
namespace {

/// How long the first look waits for parameters: a slave that does not answer must not hold up the others.
constexpr std::chrono::milliseconds kFirstRound(2000);

/// The arguments as they were typed.
struct WatchTexts {
  std::vector<std::string> slaves;
  std::vector<std::string> parameters;
  std::string interval = "500";
  std::string count = "0";
  bool raw = false;
  bool plain = false;
};

/// Shows the rows; makes the table anew when mapping or names have changed its columns.
class Display {
 public:
  Display(Output& output, std::string bus, bool raw, bool in_place)
      : output_(output), bus_(std::move(bus)), raw_(raw), in_place_(in_place) {}

  void show(const client::MasterStatus& status, const std::vector<WatchRow>& rows) {
    const std::int64_t now = wall_clock();
    if (output_.json()) {
      for (const WatchRow& row : rows) output_.object(row_object(row, now));
      return;
    }
    const std::string columns = WatchTable(rows, !in_place_, raw_).table().heading();
    const bool fresh = !table_ || columns != columns_;
    if (fresh) table_.emplace(rows, !in_place_, raw_);
    columns_ = columns;
    table_->fill(rows, now);
    if (in_place_) {
      output_.redraw(fmt::format("bus {}, {}   {}   Ctrl-C ends", bus_, status.state, time_text(now, true)),
                     table_->table());
      return;
    }
    if (fresh) output_.line(table_->table().heading());
    for (const std::string& line : table_->table().lines()) output_.line(line);
  }

 private:
  Output& output_;
  std::string bus_;
  bool raw_;
  bool in_place_;
  std::string columns_;
  std::optional<WatchTable> table_;
};

/// The rows with what is known of their parameters, whose next round begins.
std::vector<WatchRow> rows_now(Session& session, const LiveSettings& settings, FaultWords& faults,
                               ParameterTurns& turns) {
  std::vector<WatchRow> rows = watch_rows(session.client(), settings.slaves, faults);
  for (WatchRow& row : rows) row.parameters = turns.of(row.status.slave);
  for (const std::string& problem : turns.take_problems()) session.output().remark(problem);
  turns.begin_round();
  return rows;
}

/// Lines, or with `in_place` the table drawn over the former one, `count` times in all or (0) until a signal. Nothing:
/// names mean something else now.
std::optional<ExitCode> watch_lines(Session& session, const LiveSettings& settings, std::int64_t& shown,
                                    std::int64_t count, bool in_place) {
  client::Client& client = session.client();
  Display display(session.output(), client.gateway_status().bus, settings.raw, in_place);
  FaultWords faults(session);
  Restarts restarts(client);
  ParameterTurns turns(client, settings.parameters, session.monitoring_ms());
  turns.begin_round();
  turns.await_round(std::chrono::steady_clock::now() + kFirstRound);
  auto next = std::chrono::steady_clock::now();
  while (true) {
    if (restarts.gone()) {
      session.output().remark("the daemon has gone (" + client.place() + ")");
      return ExitCode::not_reachable;
    }
    if (restarts.take()) {
      if (!session.json() && !in_place) session.output().line("");
      session.output().remark(kStartedAnew);
    }
    restarts.expect_one();
    if (!session.names_changed().empty()) return std::nullopt;
    display.show(client.master_status(), rows_now(session, settings, faults, turns));
    ++shown;
    if (shown == count) return ExitCode::done;
    next = std::max(next + settings.interval, std::chrono::steady_clock::now());
    if (wait_until(next)) return ExitCode::done;
  }
}

/// The screen; nothing, with a remark, when the terminal cannot be drawn on.
std::unique_ptr<LiveScreen> take_screen(Output& output) {
  try {
    return std::make_unique<LiveScreen>(output.colours());
  } catch (const std::runtime_error& error) {
    output.remark(fmt::format("{}; plain lines instead", error.what()));
    return nullptr;
  }
}

ExitCode watch_verb(Session& session, const WatchTexts& texts) {
  if (texts.parameters.empty()) session.look_only();
  constexpr std::int64_t kLongest = 3'600'000;
  const auto interval = std::chrono::milliseconds(parse_integer(texts.interval, "--interval", 1, kLongest));
  const std::int64_t count = parse_integer(texts.count, "--count", 0, 1'000'000'000);
  LiveSettings settings;
  const auto look_up = [&] {
    const bool every_slave = texts.slaves.empty();
    const std::uint32_t slaves = session.configured_slaves(texts.slaves);
    settings = {slaves, every_slave, interval, texts.raw,
                find_watched(session, texts.parameters, slaves, !every_slave)};
  };
  look_up();
  await_values(session.client(), settings.slaves);
  Output& output = session.output();
  const bool drawable = !texts.plain && !session.json() && output.data_on_terminal() && terminal_draws();
  const bool live = drawable && count == 0 && full_screen_possible();
  const std::unique_ptr<LiveScreen> screen = live ? take_screen(output) : nullptr;
  for (std::int64_t shown = 0;;) {
    const std::optional<ExitCode> ended =
        screen ? watch_live(session, *screen, settings)
               : watch_lines(session, settings, shown, count, drawable && !live);
    if (ended) return *ended;
    constexpr std::chrono::milliseconds kLook(100);
    while (!session.follow_names(look_up, screen != nullptr))
      if (wait_until(std::chrono::steady_clock::now() + kLook)) return ExitCode::done;
  }
}

}  // namespace

void add_watch_verb(CLI::App& app, Verb& chosen) {
  auto* watch = app.add_subcommand("watch", "the actual values of the slaves, again and again");
  watch->group(kLookingVerbs);
  auto texts = std::make_shared<WatchTexts>();
  watch->add_option("SLAVE", texts->slaves,
                    "numbers, names, or lists such as 1,3,5-9 (default: every configured slave)");
  watch
      ->add_option(
          "--parameter", texts->parameters,
          "also these parameters, by numbers or names with commas, read in turn; may be repeated, up "
          "to 8 in all")
      ->type_name("PARAMETERS")
      ->allow_extra_args(false);
  watch
      ->add_option("--interval", texts->interval,
                   "milliseconds from one look to the next, 1..3600000 (default 500)")
      ->type_name("MS");
  watch->add_option("--count", texts->count, "how often to look; 0 = until Ctrl-C (default)")->type_name("N");
  watch->add_flag("--raw", texts->raw, "numbers as on the bus instead of scaled ones");
  watch->add_flag("--plain", texts->plain, "lines, also on a terminal, instead of the full-screen view");
  watch->footer(
      "On a terminal: a full-screen view with trends, bus load, timing and events, until q; ? explains its "
      "keys.\n"
      "With --count the table alone is redrawn in place. Otherwise, and with --plain or TERM=dumb, every "
      "look adds\n"
      "one line for each slave.\n" +
      columns_help(watch_columns()) + "\n\n" + live_help());
  watch->callback(
      [texts, &chosen] { chosen = [texts](Session& session) { return watch_verb(session, *texts); }; });
}

}  // namespace cansync::cli
