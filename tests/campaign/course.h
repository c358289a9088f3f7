#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "coverage.h"
#include "daemon/cansync/realtime/realtime_loop.h"
#include "player.h"
#include "scene.h"

namespace cansyncd::campaign {

/// An invariant that did not hold.
struct Violation {
  std::string invariant;
  std::string what;
  std::uint64_t interval = 0;  ///< number of the interval after which it was seen
};

/// What became of one schedule.
struct Verdict {
  std::uint64_t digest = 0;  ///< of everything that was on the bus and every answer
  std::uint64_t intervals = 0;
  std::uint64_t allowed = 0;  ///< intervals from the last fault to normal operation, 0: not looked at
  std::uint64_t took = 0;     ///< and how many it took
  std::optional<Violation> violation;
  Coverage coverage;
};

/// One schedule from start to end: the daemon's realtime loop on the simulated line in virtual time, with
/// the player in the place of gateway, clients and operator, and every invariant checked after every
/// interval. Call `run` once. Everything happens on the caller's thread.
class Course {
 public:
  /// `plan` must outlive the course. `tamper` breaks the product on purpose; null: it is as it is.
  /// `tell` is told the whole course in words; empty: nobody wants to know.
  Course(const Plan& plan, Tamper* tamper, std::function<void(const std::string&)> tell);
  ~Course();

  Verdict run();

  /// Called after every interval with how many there were; what it says is wrong counts as a violation.
  std::function<std::optional<std::string>(std::uint64_t)> on_interval;

  sim::Line& line() noexcept { return *line_; }
  /// As the master was at the end of the last interval.
  const MasterSnapshot& snapshot() const noexcept { return scene_.now; }
  /// Requests with an answer of their own, so far.
  std::uint64_t requests() const noexcept { return ledger_.pushed(); }

 private:
  void waits();
  void interval_ended();
  void look_at_values();
  void look_at_stops();
  void look_at_drives(bool all);
  void judge();
  void follow_phases();
  void finish();
  void violated(const char* invariant, const std::string& what);
  void show_trace();
  sim::Drive& drive(std::size_t index) { return dynamic_cast<sim::Drive&>(line_->node(index)); }
  bool everything_over() const;
  sim::LineSettings line_settings();

  const Plan& plan_;
  Tamper* tamper_;
  std::function<void(const std::string&)> tell_;
  Verdict verdict_;
  Witness witness_;
  Ledger ledger_;
  ParameterTruth parameters_;
  MemoryTruth memories_;
  Recovery recovery_;
  std::unique_ptr<sim::Line> line_;
  Exchange exchange_;
  WordTruth words_;
  StageBus bus_;
  RealtimeLoop loop_;
  Player player_;
  Scene scene_;
  std::uint64_t tick_ = 0;
  std::size_t next_cycle_ = 0;
  std::uint64_t normal_since_ = 0;
  bool was_active_ = false;
  std::deque<std::string> trace_;  ///< the last frames, in words
  std::uint64_t stop_after_ = 0;   ///< a violation was seen: the tick after which to stop
};

}  // namespace cansyncd::campaign
