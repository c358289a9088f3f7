#include "cli/watch/live_model.h"

#include <algorithm>
#include <bit>

#include "cli/base/session.h"

namespace cansync::cli {
namespace {

constexpr std::int64_t kMillisecond = 1'000'000;  // ns

void take_values(LiveSlave& slave, const WatchRow& row, bool alive) {
  const unsigned mapped = mapped_values(row.status.actual_mapping);
  for (unsigned i = 0; i < kSlaveValues; ++i) {
    LiveValue& value = slave.values[i];
    value.name = row.status.actual_value[i].name;
    value.unit = row.status.actual_value[i].unit_symbol;
    value.mapped = ((mapped >> i) & 1u) != 0;
    value.scaled.reset();
    if (((row.shown >> i) & 1u) != 0) {
      value.scaled = row.values->scaled[i];
      value.raw = raw_number(*row.values, i, raw_form(row.status.actual_value[i]).is_signed);
    }
    // What a slave that does not answer said last is no point of a trend.
    value.trend.add(alive ? value.scaled : std::nullopt);
  }
}

void take_parameters(LiveSlave& slave, const WatchRow& row, bool alive, std::int64_t now) {
  slave.read_ms = oldest_ms(row.parameters, now);
  slave.read_failed = false;
  for (std::size_t i = 0; i < kMostParameters; ++i) {
    LiveValue& value = slave.values[kSlaveValues + i];
    value.mapped = i < row.parameters.size() && row.parameters[i].asked;
    value.scaled.reset();
    if (value.mapped) {
      const WatchedParameter& parameter = row.parameters[i];
      value.name = heading_of(parameter);
      value.words = parameter.by_name ? words_of(parameter) : "";
      value.unit = parameter.by_name && parameter.known != nullptr ? parameter.known->unit : "";
      slave.read_failed = slave.read_failed || (parameter.last && !parameter.last->ok());
      if (parameter.value) {
        value.raw = raw_number(parameter);
        value.scaled = parameter.by_name ? scaled_number(parameter) : std::nullopt;
        if (!value.scaled) value.scaled = static_cast<double>(value.raw);
      }
    }
    value.trend.add(alive ? value.scaled : std::nullopt);
  }
}

}  // namespace

void Trend::add(std::optional<double> point) {
  points_[added_ % kTrendPoints] = point;
  ++added_;
}

std::vector<std::optional<double>> Trend::last(std::size_t count) const {
  const std::size_t there = std::min({count, added_, kTrendPoints});
  std::vector<std::optional<double>> out;
  for (std::size_t i = added_ - there; i < added_; ++i) out.push_back(points_[i % kTrendPoints]);
  return out;
}

LiveSlave& LiveModel::slave(unsigned number) {
  const auto place = std::find_if(slaves_.begin(), slaves_.end(),
                                  [number](const LiveSlave& slave) { return slave.number >= number; });
  if (place != slaves_.end() && place->number == number) return *place;
  LiveSlave fresh;
  fresh.number = number;
  return *slaves_.insert(place, std::move(fresh));
}

void LiveModel::look(const LineFacts& line, const client::MasterStatus& status,
                     const std::vector<WatchRow>& rows, std::int64_t now) {
  now_ = now;
  master_.line = line;
  master_.state = status.state;
  master_.configured = static_cast<unsigned>(std::popcount(status.slaves_configured));
  master_.synchronized = static_cast<unsigned>(std::popcount(status.slaves_synchronized));
  master_.released = static_cast<unsigned>(std::popcount(status.slaves_released));
  std::erase_if(slaves_, [&rows](const LiveSlave& known) {
    return std::none_of(rows.begin(), rows.end(),
                        [&known](const WatchRow& row) { return row.status.slave == known.number; });
  });
  for (const WatchRow& row : rows) {
    LiveSlave& known = slave(row.status.slave);
    known.name = row.status.name;
    known.state = row.status.state;
    known.responds = row.status.responds;
    known.status_word.reset();
    if (row.status.status_known) known.status_word = row.status.status_word;
    known.fault = row.fault;
    known.answers = row.status.answers;
    known.age_ms.reset();
    if (row.values) known.age_ms = std::max<std::int64_t>(0, (now - row.values->receive_time) / kMillisecond);
    take_values(known, row, known.responds && present_);
    take_parameters(known, row, known.responds && present_, now);
  }
}

void LiveModel::take(const client::Timing& timing) {
  // A daemon that was started again counts from the beginning.
  if (!samples_.empty() && timing.intervals < samples_.back().intervals) samples_.clear();
  samples_.push_back(timing);
  if (samples_.size() > kTimingSeconds + 1) samples_.pop_front();
  std::vector<client::Timing> counted(samples_.begin(), samples_.end());
  if (counted.size() == 1) {
    timing_ = timing_report(counted, nullptr, master_.line);
    return;
  }
  const client::Timing before = counted.front();
  counted.erase(counted.begin());
  timing_ = timing_report(counted, &before, master_.line);
}

void LiveModel::take(const client::Event& event) {
  events_.push_back({event.time, event.severity, event.code, event.text});
  if (events_.size() > kLiveEvents) events_.pop_front();
}

void LiveModel::tell(std::int64_t time, std::string code, std::string text) {
  events_.push_back({time, gateway_SEVERITY_WARNING, std::move(code), std::move(text)});
  if (events_.size() > kLiveEvents) events_.pop_front();
}

void LiveModel::set_daemon(bool present, std::string place) {
  present_ = present;
  place_ = std::move(place);
}

}  // namespace cansync::cli
