#pragma once

#include <algorithm>
#include <chrono>
#include <utility>

namespace cansync::cli {

/// The time of a recording: its duration counts from the first row on, because the daemon's values are not there at
/// once. Reads no clock.
class RecordTime {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// How long the first row is waited for, whatever the duration is.
  static constexpr std::chrono::seconds kFirstRow{10};

  /// A recording that begins at `now` and takes `duration`, over 0.
  RecordTime(std::chrono::duration<double> duration, Time now)
      : duration_(duration), start_(now + kFirstRow) {}

  /// Says that there are rows at `now`; the first call counts.
  void rows_are_there(Time now) {
    if (!std::exchange(begun_, true)) start_ = now;
  }

  /// Seconds since the first row; without one since none is waited for any longer, until then 0.
  double seconds(Time now) const {
    return std::max(0.0, std::chrono::duration<double>(now - start_).count());
  }
  /// What is left of the duration; 0 or less at its end.
  std::chrono::duration<double> left(Time now) const {
    return duration_ - std::chrono::duration<double>(seconds(now));
  }

 private:
  std::chrono::duration<double> duration_;
  bool begun_ = false;
  Time start_;
};

}  // namespace cansync::cli
