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
    : raw_(raw) {
  std::vector<std::string> unknown = values;
  // By value first, so that what telegrams carry side by side stands side by side.
  for (unsigned i = 0; i < kSlaveValues; ++i) {
    for (const client::SlaveStatus& slave : slaves) {
      names_[slave.slave] = slave.name;
      if (((mapped_values(slave.actual_mapping) >> i) & 1u) == 0) continue;
      const auto fits = [&](const std::string& wanted) { return is_one_of(slave, i, wanted); };
      if (!values.empty() && std::none_of(values.begin(), values.end(), fits)) continue;
      std::erase_if(unknown, fits);
      const std::string text = heading(slave, i, raw);
      const auto found = std::find(headings_.begin(), headings_.end(), text);
      signed_[{slave.slave, i}] = raw_form(slave.actual_value[i]).is_signed;
      columns_[{slave.slave, i}] = static_cast<std::size_t>(found - headings_.begin());
      if (found == headings_.end()) headings_.push_back(text);
    }
  }
  if (!unknown.empty() || headings_.empty())
    throw UsageError(fmt::format("--values: found '{}'; allowed, of these slaves: {}",
                                 fmt::join(unknown, ","), known_names(slaves)));
}

std::optional<std::size_t> RecordPlan::column(unsigned slave, unsigned value) const {
  const auto found = columns_.find({slave, value});
  return found == columns_.end() ? std::nullopt : std::optional(found->second);
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
