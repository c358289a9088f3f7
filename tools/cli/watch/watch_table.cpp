#include "cli/watch/watch_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "cli/base/session.h"

namespace cansync::cli {
namespace {

constexpr std::int64_t kOneMillisecond = 1'000'000;  // ns

JsonObject parameter_object(const WatchedParameter& parameter, std::int64_t now) {
  JsonObject object;
  object.add("parameter", parameter.typed);
  if (parameter.asked)
    object.add("number", parameter.number);
  else
    object.add_null("number");
  if (parameter.value) {
    object.add("raw", raw_number(parameter))
        .add("format", parameter.value->doubleword ? "doubleword" : "word");
  } else {
    object.add_null("raw").add_null("format");
  }
  if (const auto scaled = scaled_number(parameter))
    object.add("scaled", *scaled);
  else
    object.add_null("scaled");
  if (parameter.known != nullptr)
    object.add("unit", parameter.known->unit);
  else
    object.add_null("unit");
  object.add("words", words_of(parameter));
  if (parameter.value)
    object.add("read_time_ns", parameter.time)
        .add("age_ms", std::max<std::int64_t>(0, (now - parameter.time) / kOneMillisecond));
  else
    object.add_null("read_time_ns").add_null("age_ms");
  if (parameter.last)
    return object.add("result", client::name(parameter.last->code)).add("reason", parameter.last->reason);
  return object.add_null("result").add("reason", "");
}

}  // namespace

JsonObject row_object(const WatchRow& row, std::int64_t now) {
  JsonObject object;
  object.add("slave", row.status.slave).add("name", row.status.name);
  JsonArray intervals;
  JsonArray values;
  if (row.values) {
    object.add("receive_time_ns", row.values->receive_time)
        .add("age_ms", (now - row.values->receive_time) / kOneMillisecond);
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
  JsonArray parameters;
  for (const WatchedParameter& parameter : row.parameters)
    parameters.add_json(parameter_object(parameter, now).text());
  return object.add("intervals", intervals)
      .add("values", values)
      .add("fault", row.fault)
      .add("parameters", parameters);
}

std::vector<Table::Column> watch_columns() {
  constexpr auto left = Table::Align::left;
  constexpr auto right = Table::Align::right;
  return {{"TIME", left, "when it was looked at (not on a terminal)"},
          {"SLAVE", right, "its number"},
          {"NAME", left, "its configured name"},
          {"AGE ms", right, "time since the slave's newest actual value telegram; - = none yet"},
          {"READ ms", right,
           "with --parameter: time since the oldest of the slave's parameter values was read; - = none yet"},
          {"FAULT", left, "faults in its status word, as its profile calls them; - = none known"},
          {"VALUE n", right,
           "actual value n with its unit, in a column that is headed by its configured name if it has one; - "
           "= not mapped, or its telegram never came"},
          {"PARAMETER n", right,
           "with --parameter: parameter n as it was read last; of one that was given by name, under its name "
           "and with its unit; - = never read, or the slave's profile does not have it"}};
}

WatchTable::WatchTable(const std::vector<WatchRow>& rows, bool with_time, bool raw)
    : raw_(raw), with_time_(with_time), table_(columns(rows)) {}

void WatchTable::fill(const std::vector<WatchRow>& rows, std::int64_t now) {
  table_.clear();
  for (const WatchRow& row : rows) table_.add(cells(row, now));
}

std::vector<Table::Column> WatchTable::columns(const std::vector<WatchRow>& rows) {
  std::vector<Table::Column> out = watch_columns();
  const Table::Column parameter = out.back();
  out.pop_back();
  const Table::Column value = out.back();
  out.pop_back();
  const WatchRow* reads = nullptr;
  for (const WatchRow& row : rows)
    if (!row.parameters.empty()) reads = &row;
  if (reads == nullptr) out.erase(out.begin() + 4);
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
  if (reads == nullptr) return out;
  parameters_ = reads->parameters.size();
  for (const WatchedParameter& read : reads->parameters) {
    out.push_back(parameter);
    out.back().heading =
        looks_like_number(read.typed) ? fmt::format("PARAMETER {}", read.number) : read.typed;
  }
  return out;
}

std::vector<std::string> WatchTable::cells(const WatchRow& row, std::int64_t now) const {
  std::vector<std::string> out;
  if (with_time_) out.push_back(time_text(now, false));
  out.push_back(fmt::format("{}", row.status.slave));
  out.emplace_back(row.status.name);
  out.push_back(row.values ? fmt::format("{}", (now - row.values->receive_time) / kOneMillisecond) : "-");
  if (parameters_ > 0) {
    const auto oldest = oldest_ms(row.parameters, now);
    out.push_back(oldest ? fmt::format("{}", *oldest) : "-");
  }
  out.push_back(row.fault.empty() ? "-" : row.fault);
  for (unsigned i = 0; i < kSlaveValues; ++i)
    if (((mapped_ >> i) & 1u) != 0) out.push_back(cell(row, i));
  for (std::size_t i = 0; i < parameters_; ++i)
    out.push_back(i < row.parameters.size() ? text_of(row.parameters[i], raw_) : "-");
  return out;
}

std::string WatchTable::cell(const WatchRow& row, unsigned value) const {
  if (((row.shown >> value) & 1u) == 0) return "-";
  const auto& name = row.status.actual_value[value];
  if (raw_) return fmt::format("{}", raw_number(*row.values, value, raw_form(name).is_signed));
  const std::string_view unit = name.unit_symbol;
  // Ten digits hold every 32-bit number, and hide the last bits of a factor such as 0.1.
  return fmt::format("{:.10g}{}{}", row.values->scaled[value], unit.empty() ? "" : " ", unit);
}

}  // namespace cansync::cli
