#include "cli/record/recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <utility>

#include "cli/base/session.h"
#include "cli/text/csv.h"

namespace cansync::cli {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;  // ns
/// Intervals after which both telegrams of a slave have certainly come.
constexpr std::uint64_t kSettled = 2;
/// No interval was seen since the daemon was started.
constexpr std::uint64_t kNone = ~std::uint64_t{0};

std::string value_name(const client::SlaveStatus& slave, unsigned value) {
  const std::string name = slave.actual_value[value].name;
  return name.empty() ? fmt::format("value{}", value) : name;
}

std::string heading(const client::SlaveStatus& slave, unsigned value, bool raw) {
  const std::string unit = raw ? "raw" : slave.actual_value[value].unit_symbol;
  return value_name(slave, value) + (unit.empty() ? "" : " [" + unit + "]");
}

/// Whether this value is one of the wanted ones, by name, as "value3" or "3".
bool is_one_of(const client::SlaveStatus& slave, unsigned value, const std::string& wanted) {
  return wanted == slave.actual_value[value].name || wanted == fmt::format("value{}", value) ||
         wanted == fmt::format("{}", value);
}

std::string known_names(std::span<const client::SlaveStatus> slaves) {
  std::vector<std::string> names;
  for (const client::SlaveStatus& slave : slaves)
    for (unsigned i = 0; i < kSlaveValues; ++i)
      if (const std::string name = value_name(slave, i);
          ((mapped_values(slave.actual_mapping) >> i) & 1u) != 0 &&
          std::find(names.begin(), names.end(), name) == names.end())
        names.push_back(name);
  return names.empty() ? "none, the slaves have no value mapped" : fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace

RecordPlan::RecordPlan(std::span<const client::SlaveStatus> slaves, const std::vector<std::string>& values,
                       bool raw)
    : wanted_(values), raw_(raw) {
  std::vector<std::string> unknown = values;
  for (const client::SlaveStatus& slave : slaves) {
    names_[slave.slave] = slave.name;
    values_[slave.slave] = values_of(slave);
  }
  // By value first, so that what telegrams carry side by side stands side by side.
  for (unsigned i = 0; i < kSlaveValues; ++i) {
    for (const client::SlaveStatus& slave : slaves) {
      const auto& value = values_[slave.slave][i];
      if (!value) continue;
      std::erase_if(unknown, [&](const std::string& wanted) { return is_one_of(slave, i, wanted); });
      if (!column_of(*value)) headings_.push_back(value->heading);
    }
  }
  if (!unknown.empty() || headings_.empty())
    throw UsageError(fmt::format("--values: found '{}'; allowed, of these slaves: {}",
                                 fmt::join(unknown, ","), known_names(slaves)));
}

bool RecordPlan::is_wanted(const client::SlaveStatus& slave, unsigned value) const {
  if (((mapped_values(slave.actual_mapping) >> value) & 1u) == 0) return false;
  return wanted_.empty() || std::any_of(wanted_.begin(), wanted_.end(), [&](const std::string& wanted) {
           return is_one_of(slave, value, wanted);
         });
}

RecordPlan::Values RecordPlan::values_of(const client::SlaveStatus& slave) const {
  Values values;
  for (unsigned i = 0; i < kSlaveValues; ++i) {
    if (!is_wanted(slave, i)) continue;
    const auto& told = slave.actual_value[i];
    values[i] = {heading(slave, i, raw_), raw_ ? 1 : told.factor, raw_ ? 0 : told.offset,
                 raw_form(told).is_signed};
  }
  return values;
}

std::optional<std::size_t> RecordPlan::column_of(const Value& value) const {
  const auto found = std::find(headings_.begin(), headings_.end(), value.heading);
  if (found == headings_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - headings_.begin());
}

std::optional<std::size_t> RecordPlan::column(unsigned slave, unsigned value) const {
  const auto found = values_.find(slave);
  if (found == values_.end() || !found->second[value]) return std::nullopt;
  return column_of(*found->second[value]);
}

bool RecordPlan::knows(const client::SlaveStatus& slave) const {
  const auto name = names_.find(slave.slave);
  return name != names_.end() && name->second == client::text(slave.name) &&
         values_.at(slave.slave) == values_of(slave);
}

/// Empty: the reader of the file sees it.
std::string RecordPlan::difference(const std::optional<Value>& before,
                                   const std::optional<Value>& now) const {
  const bool is_known = before && column_of(*before);
  if (!now) return is_known ? "it is not mapped any more" : "";
  if (!column_of(*now))
    return fmt::format("it is '{}', for which the file has no column: it is not recorded", now->heading);
  if (!is_known || before->heading != now->heading) return fmt::format("it is '{}'", now->heading);
  if (before->factor != now->factor || before->offset != now->offset)
    return fmt::format("'{}' is number * {:g} + {:g}", now->heading, now->factor, now->offset);
  return fmt::format("'{}' is {}", now->heading, now->is_signed ? "signed" : "unsigned");
}

std::vector<std::string> RecordPlan::update(const client::SlaveStatus& slave) {
  if (knows(slave)) return {};
  std::vector<std::string> out;
  const std::string name = slave.name;
  const auto [known, is_new] = names_.try_emplace(slave.slave, name);
  if (is_new) {
    out.push_back(fmt::format("slave {} is recorded from here on", slave.slave));
  } else if (known->second != name) {
    out.push_back(
        fmt::format("slave {} is '{}' from here on, and was '{}'", slave.slave, name, known->second));
    known->second = name;
  }
  Values now = values_of(slave);
  Values& before = values_[slave.slave];
  for (unsigned i = 0; i < kSlaveValues; ++i) {
    if (before[i] == now[i]) continue;
    if (const std::string text = difference(before[i], now[i]); !text.empty())
      out.push_back(fmt::format("slave {}, value {}: from here on {}", slave.slave, i, text));
  }
  before = std::move(now);
  return out;
}

std::vector<unsigned> RecordPlan::slaves() const {
  std::vector<unsigned> out;
  for (const auto& [slave, name] : names_) out.push_back(slave);
  return out;
}

std::string RecordPlan::header() const {
  std::string out = fmt::format("{}", fmt::join(kRecordColumns, ","));
  for (const std::string& text : headings_) out += ',' + csv_field(text);
  return out + '\n';
}

void RecordRows::set_polling(const client::MasterStatus& status) {
  polling_ = {status.polling_one, status.polling_two};
  round_ = static_cast<std::uint64_t>(std::max(status.maximum_slave, 0)) + 1;
}

void RecordRows::count_missing(unsigned slave, Seen& seen, std::uint64_t interval) {
  std::optional<std::uint64_t> period;
  for (const std::int32_t code : polling_) {
    if (code == client::kAutomatic) period = std::min(period.value_or(round_), round_);
    if (code == static_cast<std::int32_t>(slave)) period = 1;
  }
  if (!period || !seen.row || interval < *seen.row + *period) return;
  counts_.missing += (interval - *seen.row) / *period - 1;
}

void RecordRows::take_telegram(const client::ActualValues& sample, unsigned telegram) {
  Seen& seen = seen_[sample.slave];
  const std::uint64_t interval = sample.interval[telegram];
  if (seen.interval[telegram] == interval) return;  // an earlier sample has brought it
  seen.interval[telegram] = interval;
  if (seen.row != interval) {
    count_missing(sample.slave, seen, interval);
    seen.row = interval;
  }
  newest_ = std::max(newest_, interval);
  Row& row = open_[{interval, sample.slave}];
  row.time = sample.receive_time;
  for (unsigned i = 4 * telegram; i < 4 * telegram + 4; ++i) {
    if (!plan_.column(sample.slave, i)) continue;
    row.values[i] = plan_.raw() ? static_cast<double>(raw_number(sample, i, plan_.is_signed(sample.slave, i)))
                                : sample.scaled[i];
  }
}

void RecordRows::take(const client::ActualValues& sample) {
  if (!plan_.records(sample.slave)) return;
  if (of_new_start(sample)) {
    begin_again(sample.receive_time);
    began_again_ = true;
  }
  if (const auto [seen, fresh] = seen_.try_emplace(sample.slave); fresh) {
    seen->second.interval = {sample.interval[0], sample.interval[1]};
    return;
  }
  for (unsigned telegram = 0; telegram < 2; ++telegram)
    if (((sample.ever >> telegram) & 1u) != 0) take_telegram(sample, telegram);
}

/// Within one start of the daemon the numbers of intervals never fall.
bool RecordRows::of_new_start(const client::ActualValues& sample) const {
  const auto seen = seen_.find(sample.slave);
  if (seen == seen_.end()) return false;
  for (unsigned telegram = 0; telegram < 2; ++telegram) {
    const std::uint64_t last = seen->second.interval[telegram];
    if (((sample.ever >> telegram) & 1u) != 0 && last != kNone && sample.interval[telegram] < last)
      return true;
  }
  return false;
}

std::string RecordRows::lines(bool all) {
  std::string out = std::exchange(before_, {}) + take_lines(all);
  newest_before_ = newest_;
  return out;
}

std::string RecordRows::take_lines(bool all) {
  std::string out;
  while (!open_.empty() && (all || open_.begin()->first.first + kSettled < newest_before_)) {
    const auto& [place, row] = *open_.begin();
    Seen& seen = seen_[place.second];
    if (seen.rows++ % every_ == 0) out += line(place, row);
    open_.erase(open_.begin());
  }
  return out;
}

void RecordRows::restarted(std::int64_t now) {
  if (!std::exchange(began_again_, false)) begin_again(now);
}

std::vector<std::string> RecordRows::update(const client::SlaveStatus& slave, std::int64_t now) {
  if (plan_.knows(slave)) return {};
  before_ += take_lines(true);
  std::vector<std::string> changes = plan_.update(slave);
  for (std::string comment : changes) {
    std::replace(comment.begin(), comment.end(), '"', '\'');  // a comment is no field of the file
    before_ += fmt::format("# {} {}\n", utc_text(now), comment);
  }
  return changes;
}

void RecordRows::begin_again(std::int64_t now) {
  before_ += take_lines(true);
  before_ += fmt::format("# {} the daemon was started anew, interval numbers begin again\n", utc_text(now));
  for (auto& [slave, seen] : seen_) {
    seen.row.reset();
    seen.interval.fill(kNone);
  }
  newest_ = newest_before_ = 0;
}

std::string RecordRows::line(const Place& place, const Row& row) {
  std::vector<std::optional<double>> cells(plan_.headings().size());
  for (unsigned i = 0; i < kSlaveValues; ++i)
    if (const auto column = plan_.column(place.second, i)) cells[*column] = row.values[i];
  if (!first_time_) first_time_ = row.time;
  ++counts_.rows;
  std::string out = fmt::format("{},{:.6f},{},{},{},{}", utc_text(row.time),
                                static_cast<double>(row.time - *first_time_) / 1e9, row.time, place.first,
                                place.second, csv_field(plan_.name(place.second)));
  // Ten digits hold every 32-bit number, and hide the last bits of a factor such as 0.1.
  for (const auto& cell : cells) out += cell ? fmt::format(",{:.10g}", *cell) : ",";
  return out + '\n';
}

std::string utc_text(std::int64_t nanoseconds) {
  const auto seconds = static_cast<std::time_t>(nanoseconds / kSecond);
  std::tm parts{};
  std::array<char, 32> text{};
  if (gmtime_r(&seconds, &parts) == nullptr ||
      std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%S", &parts) == 0)
    return "?";
  return fmt::format("{}.{:09d}Z", text.data(), nanoseconds % kSecond);
}

}  // namespace cansync::cli
