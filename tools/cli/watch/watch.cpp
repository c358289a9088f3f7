#include <fmt/format.h>

#include <ctime>
#include <memory>

#include "cli/base/interrupt.h"
#include "cli/base/restarts.h"
#include "cli/base/verb_groups.h"
#include "cli/text/column_help.h"
#include "cli/watch/verbs.h"
#include "cli/watch/watch_live.h"
#include "cli/watch/watch_rows.h"

namespace cansync::cli {
namespace {

constexpr std::int64_t kMillisecond = 1'000'000;  // ns

/// The arguments as they were typed.
struct WatchTexts {
  std::vector<std::string> slaves;
  std::string interval = "500";
  std::string count = "0";
  bool raw = false;
  bool plain = false;
};

JsonObject row_object(const WatchRow& row, std::int64_t now) {
  JsonObject object;
  object.add("slave", row.status.slave).add("name", row.status.name);
  JsonArray intervals;
  JsonArray values;
  if (row.values) {
    object.add("receive_time_ns", row.values->receive_time)
        .add("age_ms", (now - row.values->receive_time) / kMillisecond);
    for (unsigned telegram = 0; telegram < 2; ++telegram) {
      if (((row.values->ever >> telegram) & 1u) != 0)
        intervals.add(row.values->interval[telegram]);
      else
        intervals.add_null();
    }
  } else {
    object.add_null("receive_time_ns").add_null("age_ms");
    intervals.add_null().add_null();
  }
  for (unsigned i = 0; i < kSlaveValues; ++i) {
    if (((row.shown >> i) & 1u) == 0) continue;
    const auto& name = row.status.actual_value[i];
    values.add_json(JsonObject()
                        .add("value", i)
                        .add("name", name.name)
                        .add("raw", raw_number(*row.values, i, raw_form(name).is_signed))
                        .add("scaled", row.values->scaled[i])
                        .add("unit", name.unit_symbol)
                        .text());
  }
  return object.add("intervals", intervals).add("values", values).add("fault", row.fault);
}

/// What the table may show; the last stands for each of the values, under its name or number.
std::vector<Table::Column> watch_columns() {
  constexpr auto left = Table::Align::left;
  constexpr auto right = Table::Align::right;
  return {{"TIME", left, "when it was looked at (not on a terminal)"},
          {"SLAVE", right, "its number"},
          {"NAME", left, "its configured name"},
          {"AGE ms", right, "time since the slave's newest actual value telegram; - = none yet"},
          {"FAULT", left, "faults in its status word, as its profile calls them; - = none known"},
          {"VALUE n", right,
           "actual value n with its unit, in a column that is headed by its configured name if it has one; - "
           "= not mapped, or its telegram never came"}};
}

/// The table's columns: those values that any of the slaves maps, under their name when all slaves agree on
/// it.
class WatchTable {
 public:
  WatchTable(const std::vector<WatchRow>& rows, bool with_time, bool raw)
      : raw_(raw), with_time_(with_time), table_(columns(rows)) {}

  void fill(const std::vector<WatchRow>& rows, std::int64_t now) {
    table_.clear();
    for (const WatchRow& row : rows) table_.add(cells(row, now));
  }
  const Table& table() const { return table_; }

 private:
  std::vector<Table::Column> columns(const std::vector<WatchRow>& rows) {
    std::vector<Table::Column> out = watch_columns();
    const Table::Column value = out.back();
    out.pop_back();
    if (!with_time_) out.erase(out.begin());
    for (unsigned i = 0; i < kSlaveValues; ++i) {
      std::optional<std::string> name;
      bool mapped = false;
      for (const WatchRow& row : rows) {
        if (((mapped_values(row.status.actual_mapping) >> i) & 1u) == 0) continue;
        mapped = true;
        const std::string own = row.status.actual_value[i].name;
        if (name && *name != own) name = "";
        if (!name) name = own;
      }
      if (!mapped) continue;
      mapped_ |= 1u << i;
      out.push_back(value);
      out.back().heading = name->empty() ? fmt::format("VALUE {}", i) : *name;
    }
    return out;
  }

  std::vector<std::string> cells(const WatchRow& row, std::int64_t now) const {
    std::vector<std::string> out;
    if (with_time_) out.push_back(time_text(now, false));
    out.push_back(fmt::format("{}", row.status.slave));
    out.emplace_back(row.status.name);
    out.push_back(row.values ? fmt::format("{}", (now - row.values->receive_time) / kMillisecond) : "-");
    out.push_back(row.fault.empty() ? "-" : row.fault);
    for (unsigned i = 0; i < kSlaveValues; ++i)
      if (((mapped_ >> i) & 1u) != 0) out.push_back(cell(row, i));
    return out;
  }

  std::string cell(const WatchRow& row, unsigned value) const {
    if (((row.shown >> value) & 1u) == 0) return "-";
    const auto& name = row.status.actual_value[value];
    if (raw_) return fmt::format("{}", raw_number(*row.values, value, raw_form(name).is_signed));
    const std::string_view unit = name.unit_symbol;
    // Ten digits hold every 32-bit number, and hide the last bits of a factor such as 0.1.
    return fmt::format("{:.10g}{}{}", row.values->scaled[value], unit.empty() ? "" : " ", unit);
  }

  bool raw_;
  bool with_time_;
  unsigned mapped_ = 0;
  Table table_;
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

/// Lines, or with `in_place` the table drawn over the former one, `count` times or (0) until a signal.
ExitCode watch_lines(Session& session, const LiveSettings& settings, std::int64_t count, bool in_place) {
  client::Client& client = session.client();
  Display display(session.output(), client.gateway_status().bus, settings.raw, in_place);
  FaultWords faults(session);
  Restarts restarts(client);
  auto next = std::chrono::steady_clock::now();
  for (std::int64_t shown = 0;;) {
    if (restarts.gone()) {
      session.output().remark("the daemon has gone (" + client.place() + ")");
      return ExitCode::not_reachable;
    }
    if (restarts.take()) {
      if (!session.json() && !in_place) session.output().line("");
      session.output().remark(kStartedAnew);
    }
    restarts.expect_one();
    display.show(client.master_status(), watch_rows(client, settings.slaves, faults));
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
  session.look_only();
  constexpr std::int64_t kLongest = 3'600'000;
  const auto interval = std::chrono::milliseconds(parse_integer(texts.interval, "--interval", 1, kLongest));
  const std::int64_t count = parse_integer(texts.count, "--count", 0, 1'000'000'000);
  const LiveSettings settings{session.configured_slaves(texts.slaves), texts.slaves.empty(), interval,
                              texts.raw};
  await_values(session.client(), settings.slaves);
  Output& output = session.output();
  const bool drawable = !texts.plain && !session.json() && output.data_on_terminal() && terminal_draws();
  if (drawable && count == 0 && full_screen_possible()) {
    if (const auto screen = take_screen(output)) return watch_live(session, *screen, settings);
    return watch_lines(session, settings, count, false);
  }
  return watch_lines(session, settings, count, drawable);
}

}  // namespace

void add_watch_verb(CLI::App& app, Verb& chosen) {
  auto* watch = app.add_subcommand("watch", "the actual values of the slaves, again and again");
  watch->group(kLookingVerbs);
  auto texts = std::make_shared<WatchTexts>();
  watch->add_option("SLAVE", texts->slaves,
                    "numbers, names, or lists such as 1,3,5-9 (default: every configured slave)");
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
