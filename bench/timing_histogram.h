#pragma once

#include <chrono>
#include <cstdint>
#include <vector>

namespace bench {

/// Counts durations in steps of 1 us up to 100 ms, what is longer in the last step. `add` is realtime safe.
class TimingHistogram {
 public:
  TimingHistogram() : counts_(kSteps) {}

  void add(std::chrono::nanoseconds value) noexcept {
    const auto step = std::chrono::duration_cast<std::chrono::microseconds>(value).count();
    ++counts_[step < 0 ? 0 : step < kSteps ? static_cast<std::size_t>(step) : std::size_t{kSteps - 1}];
    ++total_;
  }

  std::uint64_t total() const noexcept { return total_; }

  /// Microseconds that the given share (0..1) of all durations does not exceed.
  std::uint64_t quantile(double share) const noexcept {
    const auto wanted = static_cast<std::uint64_t>(share * static_cast<double>(total_));
    std::uint64_t below = 0;
    for (std::size_t step = 0; step < counts_.size(); ++step) {
      below += counts_[step];
      if (below > wanted) return step;
    }
    return kSteps - 1;
  }

 private:
  static constexpr std::int64_t kSteps = 100'000;
  std::vector<std::uint64_t> counts_;
  std::uint64_t total_ = 0;
};

}  // namespace bench
