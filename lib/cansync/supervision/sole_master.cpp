#include "cansync/supervision/sole_master.h"

#include <utility>

namespace cansync {
namespace {

/// Another master counts as gone after so long without its frames.
constexpr Duration kQuiet = std::chrono::seconds(3);

/// The interval in which listening begins is not a whole one.
std::uint64_t whole_intervals(Duration listen, Duration interval) noexcept {
  if (listen <= Duration{0}) return 0;
  return static_cast<std::uint64_t>((listen + interval - Duration(1)) / interval) + 1;
}

}  // namespace

std::string_view name(BusAccess access) noexcept {
  switch (access) {
    case BusAccess::granted:
      return "granted";
    case BusAccess::away:
      return "away";
    case BusAccess::listening:
      return "listening";
    case BusAccess::other_master:
      return "other_master";
  }
  return "unknown_access";
}

SoleMaster::SoleMaster(Duration listen, Duration interval) noexcept
    : interval_(interval), needed_(whole_intervals(listen, interval)) {}

std::uint64_t SoleMaster::pass_interval() noexcept {
  if (away_ && needed_ != 0) return 0;
  if (listened_ < needed_) ++listened_;
  if (row_ == 0) {
    if (listened_ == needed_) accepted_ = false;
    return 0;
  }
  if (static_cast<Duration::rep>(++quiet_) * interval_ <= kQuiet) return 0;
  accepted_ = false;
  return std::exchange(row_, 0);
}

bool SoleMaster::heard(std::uint32_t identifier) noexcept {
  quiet_ = 0;
  identifier_ = identifier;
  return ++row_ == 1;
}

void SoleMaster::bus_returned() noexcept {
  away_ = accepted_ = false;
  listened_ = 0;
}

BusAccess SoleMaster::access() const noexcept {
  return accepted_ ? BusAccess::granted : unforced();
}

BusAccess SoleMaster::unforced() const noexcept {
  if (needed_ == 0) return BusAccess::granted;
  if (away_) return BusAccess::away;
  if (other()) return BusAccess::other_master;
  return listened_ < needed_ ? BusAccess::listening : BusAccess::granted;
}

}  // namespace cansync
