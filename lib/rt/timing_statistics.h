#pragma once

#include <array>
#include <bit>
#include <chrono>
#include <cstdint>

namespace rt {

/// Minimum, mean and maximum of a duration since they were last taken, and a histogram since the start.
/// One thread at a time; nothing allocates or blocks.
class TimingStatistics {
 public:
  using Duration = std::chrono::nanoseconds;
  static constexpr unsigned kBuckets = 16;

  /// What was added since the previous `take`; all zero when `count` is 0.
  struct Summary {
    std::uint64_t count = 0;
    Duration minimum{0};
    Duration mean{0};
    Duration maximum{0};
  };

  void add(Duration value) noexcept {
    if (summary_.count == 0 || value < summary_.minimum) summary_.minimum = value;
    if (summary_.count == 0 || value > summary_.maximum) summary_.maximum = value;
    ++summary_.count;
    sum_ += value;
    // What the histogram counts as zero is zero in the total too.
    if (value > Duration{0}) total_ += value;
    ++histogram_[bucket(value)];
  }

  /// Summary since the previous call, which begins a new one.
  Summary take() noexcept {
    Summary taken = summary_;
    if (taken.count > 0) taken.mean = sum_ / static_cast<std::int64_t>(taken.count);
    summary_ = {};
    sum_ = Duration{0};
    return taken;
  }

  /// Bucket n counts values under 2^n microseconds that no lower bucket counts; the last one counts the rest.
  const std::array<std::uint64_t, kBuckets>& histogram() const noexcept { return histogram_; }

  /// Sum of all values since the start; what is below zero counts as zero.
  Duration total() const noexcept { return total_; }

  /// The bucket of a value; what is below zero counts as zero.
  static constexpr unsigned bucket(Duration value) noexcept {
    const auto us = std::chrono::duration_cast<std::chrono::microseconds>(value).count();
    const auto width = static_cast<unsigned>(std::bit_width(static_cast<std::uint64_t>(us < 0 ? 0 : us)));
    return width < kBuckets ? width : kBuckets - 1;
  }

 private:
  Summary summary_;
  Duration sum_{0};
  Duration total_{0};
  std::array<std::uint64_t, kBuckets> histogram_ = {};
};

}  // namespace rt
