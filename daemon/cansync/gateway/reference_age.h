#pragma once

#include <chrono>
#include <cstdint>

#include "cansync/telegram/numbers.h"
#include "daemon/cansync/exchange.h"
#include "dds/denial.h"

namespace cansyncd {

/// Both clocks of one look. The steady one is read first: a suspension between the two makes values older
/// than they are, never younger.
struct ClockReading {
  std::chrono::steady_clock::time_point steady;
  std::int64_t wall = 0;  ///< ns since 1970
};

/// How old reference values may grow from their source time until their release begins
/// (failsafe.reference_max_age_ms). Judged once, when they come, and told as a number of an interval, which
/// holds wherever they wait afterwards and whoever is suspended meanwhile. Reads no clock. Gateway thread.
class ReferenceAge {
 public:
  /// `interval`: time from one SYNC edge to the next.
  ReferenceAge(std::chrono::milliseconds limit, can::Time interval) noexcept
      : limit_(limit), interval_(interval) {}

  /// 0: age is not looked at.
  void set_limit(std::chrono::milliseconds limit) noexcept { limit_ = limit; }
  bool looked_at() const noexcept { return limit_.count() != 0; }
  /// An instant of the line, as last heard; its clock and the gateway's are one (CLOCK_MONOTONIC).
  void set_line(const Moment& heard) noexcept { heard_ = heard; }

  /// What is said of values.
  struct Verdict {
    gateway::dds::Problem problem;             ///< why they are refused
    cansync::IntervalNumber too_old_from = 0;  ///< ReferenceUpdate::too_old_from
  };
  /// `source`: when they were written, ns since 1970.
  Verdict judge(std::int64_t source, const ClockReading& now) const;

 private:
  cansync::IntervalNumber first_interval_after(std::chrono::steady_clock::time_point instant) const noexcept;

  std::chrono::milliseconds limit_;
  can::Time interval_;
  Moment heard_;
};

}  // namespace cansyncd
