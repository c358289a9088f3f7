#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "course.h"
#include "small/other_master_plan.h"

namespace cansyncd::campaign {

/// When our daemon is cut off from its bus, as it turns out: what the kernel only takes up when it is looked at
/// comes back with the next look.
class Outages {
 public:
  struct Gap {
    Outage outage;
    can::Time back = can::Time::max();  ///< from here on frames pass again
  };

  explicit Outages(const std::vector<Outage>& plan) {
    for (const Outage& outage : plan)
      gaps_.push_back({outage, outage.kind == Outage::Kind::bus_off ? outage.to : can::Time::max()});
  }

  /// The daemon reads the state of the controller.
  void looked(can::Time now) noexcept {
    for (Gap& gap : gaps_) {
      if (gap.back == can::Time::max() && now >= gap.outage.to) gap.back = now;
    }
    look_ = now;
  }
  can::Time look() const noexcept { return look_; }

  /// The newest one that has begun by `now`; null: none.
  const Gap* newest(can::Time now) const noexcept {
    const Gap* newest = nullptr;
    for (const Gap& gap : gaps_) {
      if (gap.outage.from <= now) newest = &gap;
    }
    return newest;
  }
  /// The one at `now`; null: frames pass.
  const Gap* at(can::Time now) const noexcept {
    for (const Gap& gap : gaps_) {
      if (gap.outage.from <= now && now < gap.back) return &gap;
    }
    return nullptr;
  }

 private:
  std::vector<Gap> gaps_;
  can::Time look_{-1};
};

/// What the daemon promises about another master (docs/operations.md, "One master"), by what stood on the bus and
/// what the daemon did, whatever it thinks:
/// - It listens for `startup.listen_ms` before its first telegram and edge, and after each outage.
/// - A frame of another master that reached its controller is followed by none of ours for 3 s. In run those of
///   the same interval may still come; and the one edge that ends this interval, since SYNC is made before a
///   look, but for the first edge after silence. Once the daemon has taken the frame out of the bus, nothing
///   of ours comes.
/// - With `after_other_master = "command"` nothing comes before a command.
/// - `mode setup --force` lifts all of that until both masters were apart for 3 s and for the listening time, until
///   the bus was away, or until stop or restart.
/// What the daemon cannot know yet is no violation: it reads the state of its controller once an interval.
class OtherMasterTruth {
 public:
  /// Both must outlive the object. The loop begins at the start of the line's clock.
  OtherMasterTruth(const OtherMasterPlan& plan, const Outages& outages);

  /// The other master's frame is whole on the bus at `end`.
  void other_sent(can::Time end) { coming_.push_back(end); }
  /// Takes note of what has reached the daemon's controller by now.
  void hear(can::Time now);
  /// The loop has taken a frame of the other master out of the bus.
  void taken() noexcept { taken_ = true; }
  /// An order was given, or the daemon has confirmed it.
  void ordered(const Order& order, can::Time now) noexcept;
  void obeyed(const Order& order, can::Time now) noexcept;

  /// The bus took a telegram of ours; `reference`: of reference values.
  void telegram(bool reference, can::Time now) { acts(false, reference, now); }
  /// A SYNC edge was made.
  void edge(can::Time now) { acts(true, false, now); }

  const std::optional<Violation>& violation() const noexcept { return violation_; }
  can::Time last_edge() const noexcept { return last_edge_; }
  /// Last frame of the other master that reached the daemon's controller; before the clock: none.
  can::Time last_other() const noexcept { return last_other_; }
  bool waits_for_command() const noexcept { return needs_command_; }
  std::map<std::string, std::uint64_t> met;

  void violated(const char* invariant, const std::string& what, can::Time now);

 private:
  void acts(bool edge, bool reference, can::Time now);
  void first_of_a_row(can::Time end);
  bool forced(can::Time now);
  void check_listening(bool edge, can::Time now);
  void check_other(bool edge, can::Time now);
  bool looked_since(can::Time from, can::Time now) const noexcept;

  const OtherMasterPlan& plan_;
  const Outages& outages_;
  const can::Time interval_;
  can::Time late_{};      ///< most by which the thread wakes late
  bool may_run_ = false;  ///< run may be reached
  std::deque<can::Time> coming_;
  can::Time last_other_;
  bool row_judged_ = false;  ///< the row of frames began while nothing was forced
  bool taken_ = false;       ///< the loop has one of the row
  unsigned edges_ = 0;       ///< since the row began
  can::Time last_edge_;
  can::Time last_reference_;
  std::optional<can::Time> forced_;
  bool needs_command_ = false;
  std::optional<Violation> violation_;
};

}  // namespace cansyncd::campaign
