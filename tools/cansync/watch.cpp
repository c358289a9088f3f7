#include <fmt/format.h>

#include <ctime>
#include <memory>

#include "cansync/column_help.h"
#include "cansync/interrupt.h"
#include "cansync/verbs.h"

namespace cansync::cli {
namespace {

constexpr unsigned kValues = 8;
constexpr std::int64_t kMillisecond = 1'000'000;  // ns
constexpr auto kFirstValues = std::chrono::milliseconds(500);

/// The arguments as they were typed.
struct WatchTexts {
  std::vector<std::string> slaves;
  std::string interval = "500";
  std::string count = "0";
  bool raw = false;
};

/// One slave at one moment.
struct Row {
  client::SlaveStatus status;
  std::optional<client::ActualValues> values;
  std::uint8_t shown = 0;  ///< bit n: value n is mapped and its telegram came at least once
};

std::int64_t wall_clock() {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

/// Gives every slave's newest actual values the time to come; slaves that send none cost all of it.
void await_values(const client::Client& client, std::uint32_t wanted) {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + kFirstValues;
  for (const client::SlaveStatus& status : client.slaves()) {
    if (((wanted >> status.slave) & 1u) == 0) continue;
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now());
    static_cast<void>(client.actual_values(status.slave, std::max(left, std::chrono::milliseconds(0))));
  }
}

std::vector<Row> collect(const client::Client& client, std::uint32_t wanted) {
  std::vector<Row> rows;
  for (const client::SlaveStatus& status : client.slaves()) {
    if (((wanted >> status.slave) & 1u) == 0) continue;
    Row row{status, client.actual_values(status.slave, std::chrono::milliseconds(0)), 0};
    if (row.values) {
      const unsigned came =
          ((row.values->ever & 1u) != 0 ? 0x0Fu : 0u) | ((row.values->ever & 2u) != 0 ? 0xF0u : 0u);
      row.shown = static_cast<std::uint8_t>(mapped_values(status.actual_mapping) & came);
    }
    rows.push_back(row);
  }
  return rows;
}

std::int32_t signed_raw(const client::ActualValues& values, unsigned value) {
  return as_signed(values.raw[value], Width::doubleword);
}

JsonObject row_object(const Row& row, std::int64_t now) {
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
  for (unsigned i = 0; i < kValues; ++i) {
    if (((row.shown >> i) & 1u) == 0) continue;
    const auto& name = row.status.actual_value[i];
    values.add_json(JsonObject()
                        .add("value", i)
                        .add("name", name.name)
                        .add("raw", signed_raw(*row.values, i))
                        .add("scaled", row.values->scaled[i])
                        .add("unit", name.unit_symbol)
                        .text());
  }
  return object.add("intervals", intervals).add("values", values);
}

/// What the table may show; the last stands for each of the values, under its name or number.
std::vector<Table::Column> watch_columns() {
  constexpr auto left = Table::Align::left;
  constexpr auto right = Table::Align::right;
  return {{"TIME", left, "when it was looked at (not on a terminal)"},
          {"SLAVE", right, "its number"},
          {"NAME", left, "its configured name"},
          {"AGE ms", right, "time since the slave's newest actual value telegram; - = none yet"},
          {"VALUE n", right,
           "actual value n with its unit, in a column that is headed by its configured name if it has one; - "
           "= not "
           "mapped, or its telegram never came"}};
}

/// The table's columns: those values that any of the slaves maps, under their name when all slaves agree on
/// it.
class WatchTable {
 public:
  WatchTable(const std::vector<Row>& rows, bool with_time, bool raw)
      : raw_(raw), with_time_(with_time), table_(columns(rows)) {}

  void fill(const std::vector<Row>& rows, std::int64_t now) {
    table_.clear();
    for (const Row& row : rows) table_.add(cells(row, now));
  }
  const Table& table() const { return table_; }

 private:
  std::vector<Table::Column> columns(const std::vector<Row>& rows) {
    std::vector<Table::Column> out = watch_columns();
    const Table::Column value = out.back();
    out.pop_back();
    if (!with_time_) out.erase(out.begin());
    for (unsigned i = 0; i < kValues; ++i) {
      std::optional<std::string> name;
      bool mapped = false;
      for (const Row& row : rows) {
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

  std::vector<std::string> cells(const Row& row, std::int64_t now) const {
    std::vector<std::string> out;
    if (with_time_) out.push_back(time_text(now, false));
    out.push_back(fmt::format("{}", row.status.slave));
    out.emplace_back(row.status.name);
    out.push_back(row.values ? fmt::format("{}", (now - row.values->receive_time) / kMillisecond) : "-");
    for (unsigned i = 0; i < kValues; ++i)
      if (((mapped_ >> i) & 1u) != 0) out.push_back(cell(row, i));
    return out;
  }

  std::string cell(const Row& row, unsigned value) const {
    if (((row.shown >> value) & 1u) == 0) return "-";
    if (raw_) return fmt::format("{}", signed_raw(*row.values, value));
    const std::string_view unit = row.status.actual_value[value].unit_symbol;
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
  Display(Output& output, bool raw) : output_(output), raw_(raw), in_place_(output.data_on_terminal()) {}

  void show(const client::MasterStatus& status, const std::vector<Row>& rows) {
    const std::int64_t now = wall_clock();
    if (output_.json()) {
      for (const Row& row : rows) output_.object(row_object(row, now));
      return;
    }
    const std::string columns = WatchTable(rows, !in_place_, raw_).table().heading();
    const bool fresh = !table_ || columns != columns_;
    if (fresh) table_.emplace(rows, !in_place_, raw_);
    columns_ = columns;
    table_->fill(rows, now);
    if (in_place_) {
      output_.redraw(
          fmt::format("bus {}, {}   {}   Ctrl-C ends", status.bus, status.state, time_text(now, true)),
          table_->table());
      return;
    }
    if (fresh) output_.line(table_->table().heading());
    for (const std::string& line : table_->table().lines()) output_.line(line);
  }

 private:
  Output& output_;
  bool raw_;
  bool in_place_;
  std::string columns_;
  std::optional<WatchTable> table_;
};

ExitCode watch_verb(Session& session, const WatchTexts& texts) {
  constexpr std::int64_t kLongest = 3'600'000;
  const auto interval = std::chrono::milliseconds(parse_integer(texts.interval, "--interval", 1, kLongest));
  const std::int64_t count = parse_integer(texts.count, "--count", 0, 1'000'000'000);
  const std::uint32_t wanted = session.configured_slaves(texts.slaves);
  client::Client& client = session.client();
  await_values(client, wanted);
  Display display(session.output(), texts.raw);
  auto next = std::chrono::steady_clock::now();
  for (std::int64_t shown = 0;;) {
    if (!client.daemon_present()) {
      session.output().remark("the daemon has gone (" + client.place() + ")");
      return ExitCode::not_reachable;
    }
    display.show(client.master_status(), collect(client, wanted));
    ++shown;
    if (shown == count) return ExitCode::done;
    next = std::max(next + interval, std::chrono::steady_clock::now());
    if (wait_until(next)) return ExitCode::done;
  }
}

}  // namespace

void add_watch_verb(CLI::App& app, Verb& chosen) {
  auto* watch = app.add_subcommand("watch", "the actual values of the slaves, again and again");
  auto texts = std::make_shared<WatchTexts>();
  watch->add_option("SLAVE", texts->slaves,
                    "numbers, names, or lists such as 1,3,5-9 (default: every configured slave)");
  watch
      ->add_option("--interval", texts->interval,
                   "milliseconds from one look to the next, 1..3600000 (default 500)")
      ->type_name("MS");
  watch->add_option("--count", texts->count, "how often to look; 0 = until Ctrl-C (default)")->type_name("N");
  watch->add_flag("--raw", texts->raw, "numbers as on the bus (signed 32 bits) instead of scaled ones");
  watch->footer(
      "On a terminal the table is redrawn in place; otherwise every look adds one line for each slave.\n" +
      columns_help(watch_columns()));
  watch->callback(
      [texts, &chosen] { chosen = [texts](Session& session) { return watch_verb(session, *texts); }; });
}

}  // namespace cansync::cli
