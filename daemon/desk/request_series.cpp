#include "daemon/desk/request_series.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace cansyncd {
namespace {

/// The text of a refusal names values; which refusal it is its first word says.
std::string_view end_of(const RecordedRequest& request) {
  const std::string_view result = request.result;
  return result.substr(0, result.find(':', result.find(':') + 1));
}

std::string key_of(const RecordedRequest& request, std::string_view series) {
  return fmt::format("{}\n{}\n{}\n{}", request.who.label, request.change.action, series, end_of(request));
}

}  // namespace

SteadyTime RequestSeries::Series::due() const {
  const SteadyTime ends = came + kEnds;
  return counted == 0 ? ends : std::min(ends, recorded + kTogether);
}

bool RequestSeries::has_room(const std::string& key, std::size_t most) const {
  return series_.size() < most || series_.count(key) != 0;
}

std::optional<RequestSeries::Sum> RequestSeries::add(RecordedRequest request, SteadyTime now) {
  std::string key = key_of(request, request.change.series);
  std::string_view of;
  if (!has_room(key, kMost)) {
    of = "several";
    key = key_of(request, "");
  }
  if (!has_room(key, 2 * kMost)) {
    of = "several clients";
    key = end_of(request);
  }
  const auto [found, is_new] = series_.try_emplace(std::move(key));
  Series& series = found->second;
  if (is_new) {
    series = {request, 0, now, now, of};
    return Sum{std::move(request)};
  }
  series.newest = std::move(request);
  ++series.counted;
  series.came = now;
  return std::nullopt;
}

std::vector<RequestSeries::Sum> RequestSeries::take(SteadyTime now, bool all) {
  std::vector<Sum> sums;
  for (auto next = series_.begin(); next != series_.end();) {
    Series& series = next->second;
    if (!all && series.due() > now) {
      ++next;
      continue;
    }
    if (series.counted > 0) {
      sums.push_back({series.newest, std::exchange(series.counted, 0),
                      std::chrono::ceil<std::chrono::seconds>(now - std::exchange(series.recorded, now)),
                      series.of});
    }
    next = all || series.came + kEnds <= now ? series_.erase(next) : std::next(next);
  }
  return sums;
}

std::optional<SteadyTime> RequestSeries::next() const {
  std::optional<SteadyTime> first;
  for (const auto& [key, series] : series_) first = std::min(first.value_or(series.due()), series.due());
  return first;
}

}  // namespace cansyncd
