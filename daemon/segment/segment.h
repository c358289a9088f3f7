#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "config/problem.h"
#include "daemon/desk/event_text.h"
#include "daemon/service/heartbeat.h"
#include "daemon/service/inhibitors.h"
#include "daemon/service/journal.h"
#include "daemon/service/pending_restart.h"
#include "daemon/service/surroundings.h"

namespace cansyncd {

class Segment;

/// What reading a configuration again would change.
struct ReloadPlan {
  bool file_wrong = false;  ///< the file itself has problems; else the changes cannot be made while running
  std::vector<config::Problem> problems;   ///< not empty: nothing is to change
  std::vector<std::string> applied;        ///< keys of options that changed and take effect
  std::vector<std::string> needs_restart;  ///< keys of options that changed and keep their running value
  std::function<void()> apply;  ///< puts it all into force; empty with problems. Called at most once
  /// Keys of `needs_restart` that take effect when the line is set up anew by the segment of `anew`, which
  /// has `applied`, too. Empty: there are none.
  std::vector<std::string> needs_set_up = {};
  using Maker = std::function<std::unique_ptr<Segment>(JournalSink&)>;
  Maker anew = {};
  Maker as_before = {};  ///< with the running values
};

/// What of a plan was not taken, in words: its first problem, else the options that need a restart.
std::string not_taken(const ReloadPlan& plan);

/// One protocol on one bus, with all of its threads: bus, realtime thread, DDS side, flight recorder. What a
/// segment needs is taken when it is made, and nothing runs before `start`.
///
/// Every function is for the main thread alone, `stop` and the destructor for one thread at a time; nothing else
/// is called once `stop` was.
class Segment {
 public:
  virtual ~Segment() = default;

  /// Starts everything and returns once the realtime thread runs; tells the journal so (`daemon_running`).
  /// Called once. Throws a std::exception that names what cannot be had and the remedy; nothing but the
  /// destructor is called then, which ends what has begun.
  virtual void start() = 0;

  /// Ends the realtime thread: nothing is sent any more. Clients have their answers from `stop`, which must
  /// follow. May be called before `start` and more than once.
  virtual void end_realtime() noexcept = 0;

  /// Answers every open request of a client, ends all threads and tells the journal how files of this run
  /// ended. May be called before `start` and more than once.
  virtual void stop() noexcept = 0;

  /// Stops as `stop` does, unless the line is in active operation: false, and everything goes on. Between
  /// `start` and `stop`.
  virtual bool stop_unless_active() noexcept { return false; }

  /// How far the threads have come; the service manager's watchdog is fed while both numbers rise.
  virtual Heartbeat::Progress progress() const noexcept = 0;

  /// Saves what the flight recorder has. False: there is none, or it is off.
  virtual bool record() noexcept = 0;

  /// Reads its file again, with `overrides` ("KEY=VALUE") that win over it. Nothing changes before `apply` of
  /// the plan, which must be called or dropped before anything else here is.
  virtual ReloadPlan plan_reload(std::span<const std::string> overrides) = 0;

  /// Publishes an event on every bus of the segment.
  virtual void post(const EventText& event) = 0;

  /// Publishes what is true around every bus of the segment. Also after `start` alone.
  virtual void set_surroundings(const Surroundings& surroundings) = 0;
  /// Shows on every bus of the segment what waits for a restart, and publishes an event when that has changed.
  virtual void set_pending_restart(const PendingRestart& pending) = 0;

  /// A line of the segment, on a bus that is not simulated, is in operation.
  virtual bool in_run() const noexcept = 0;

  /// Publishes an event when the computer may no longer be kept from sleeping, or may be again.
  void tell_inhibitors(const InhibitorState& before, const InhibitorState& now);

  /// Tells clients what of `plan` was not taken: a refused file, options that need a restart.
  void tell_reload(const ReloadPlan& plan);

 protected:
  Segment() = default;
  Segment(const Segment&) = default;
  Segment& operator=(const Segment&) = default;
};

}  // namespace cansyncd
