#include "daemon/desk/request_series.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace cansyncd {
namespace {

/// The text of a refusal names values; which refusal it is its first word says.
std::string key_of(const RecordedRequest& request, std::string_view series) {
  const std::string_view result = request.result;
  const std::size_t second_colon = result.find(':', result.find(':') + 1);
  return fmt::format("{}\n{}\n{}\n{}", request.who.label, request.change.action, series,
                     result.substr(0, second_colon));
}

}  // namespace

SteadyTime RequestSeries::Series::due() const {
  const SteadyTime ends = came + kEnds;
  return counted == 0 ? ends : std::min(ends, recorded + kTogether);
}

std::optional<RequestSeries::Sum> RequestSeries::add(RecordedRequest request, SteadyTime now) {
  std::string key = key_of(request, request.change.series);
  bool several = false;
  if (series_.size() >= kMost && series_.count(key) == 0) {
    key = key_of(request, "");
    several = true;
  }
  const auto [found, is_new] = series_.try_emplace(std::move(key));
  Series& series = found->second;
  if (is_new) {
    series = {request, 0, now, now, several};
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
                      series.several});
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
