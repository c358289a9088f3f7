#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>

#include "can/bus.h"
#include "cansync/cluster/cluster.h"
#include "cansync/config/config.h"
#include "cansync/master.h"
#include "cansync/settings/settings.h"
#include "daemon/bus/bus_load.h"
#include "daemon/cansync/exchange.h"
#include "daemon/cansync/realtime/bus_watch.h"
#include "daemon/cansync/realtime/mode_control.h"
#include "daemon/cansync/realtime/reporter.h"
#include "daemon/cansync/realtime/request_intake.h"
#include "daemon/cansync/slot_statistics.h"
#include "daemon/loop/leading_edges.h"
#include "daemon/loop/sync_line.h"
#include "daemon/loop/timeline.h"
#include "daemon/loop/wall_clock.h"
#include "rt/timing_statistics.h"
#include "sync/sync_wire.h"

namespace cansyncd {

/// What the realtime loop can be told.
struct LoopSettings {
  StartTarget target = StartTarget::active;
  /// Where to go at first: what the loop before was going to, whose place this one takes. Nothing: to
  /// `target`.
  std::optional<StartTarget> first_target = std::nullopt;
  bool report_intervals = false;  ///< write `Exchange::interval` and wake the gateway right after each SYNC
  WallClock::Read wall_clock = &read_realtime_clock;  ///< null in virtual time
  /// Take frames at every wake-up. False: at the SYNC edge and after WRC2 alone, as a bus wants it for which
  /// a look costs a system call; nothing that the master decides on can have come in between.
  bool look_at_every_slot = true;
  can::Time epoch{0};                        ///< wall clock at bus time 0, when `wall_clock` is null
  FlightTap* tap = nullptr;                  ///< flight recorder; null: none
  sync_line::SyncWire* sync_wire = nullptr;  ///< wire beside the bus; null: none; must outlive the loop
  SyncLine* sync_line = nullptr;             ///< what [sync] says; null: nothing; must outlive the loop
  AfterOtherMaster after_other_master = AfterOtherMaster::resume;
  /// The loop drives the lower master of this cluster, at the edges `edges`, instead of a master of its own;
  /// null: it has its own. Both must outlive the loop; the cluster is not started.
  cansync::Cluster* cluster = nullptr;
  const LeadingEdges* edges = nullptr;
};

/// The realtime thread's work: binds the master to a bus and to the gateway, interval by interval.
///
/// Timeline: SYNC n is due at start + n * interval, for ever, or follows what the SYNC line follows, or is
/// that of a cluster.
/// Missed-tick rule: an edge for which the thread wakes more than half an interval late is not produced, nor
/// any before it; they are skipped, counted and reported. Nothing is made up for, and the timeline neither
/// drifts nor bunches up. A telegram whose latest start has passed is left out of its interval and counted.
///
/// All time comes from the bus, so the same loop runs in virtual time. The constructor takes all memory;
/// `run` neither allocates, locks, logs nor throws, and its only system calls are the bus's and the gateway's
/// wake signal (at most one for each time it sleeps).
class RealtimeLoop {
 public:
  /// `bus` and `exchange` must outlive the loop. `settings` must have passed cansync::check.
  RealtimeLoop(const cansync::MasterSettings& settings, const LoopSettings& loop, can::Bus& bus,
               Exchange& exchange);

  /// Runs until `request_stop`; then every open job and every waiting request is answered as
  /// `master_stopped`. Call once, on the realtime thread.
  void run() noexcept;

  /// Makes `run` return within one interval, in which no more requests are begun. Any thread, also a signal
  /// handler.
  void request_stop() noexcept { stop_.store(true, std::memory_order_relaxed); }

  /// As `request_stop`, unless the line is in active operation then; `run` goes on in that case, and forgets
  /// that it was asked. Waits until the realtime thread has decided. False: it goes on. One thread, while
  /// `run` runs.
  bool request_stop_unless_active() noexcept;

  /// Where the line was going when `request_stop_unless_active` said yes. After the end of `run`.
  StartTarget target_at_stop() const noexcept { return target_at_stop_; }

  /// Wake-ups for a SYNC edge so far: stands still when the thread does. Any thread.
  std::uint64_t wake_ups() const noexcept { return wake_ups_.load(std::memory_order_relaxed); }

 private:
  using Slots = std::array<cansync::Slot, cansync::kSlots>;

  void begin() noexcept;
  void end() noexcept;
  bool skip_missed_edges() noexcept;
  void begin_interval() noexcept;
  void begin_masters_interval() noexcept;
  void make_edge(can::Time due) noexcept;
  Slots slots_in_order() const noexcept;
  void serve(cansync::Slot slot) noexcept;
  void hand_over(cansync::Slot slot, const can::Frame& frame) noexcept;
  void sleep_until(can::Time deadline) noexcept;
  void receive_frames() noexcept;
  bool take_sync_frame(const can::ReceivedFrame& received) noexcept;
  void publish() noexcept;
  void publish_timing(can::Time now) noexcept;
  void refresh_slave_counters() noexcept;
  std::uint16_t cansync_status() const noexcept;
  void watch_other_master() noexcept;
  /// SYNC edges and telegrams may be sent.
  bool synchronous() const noexcept { return cansync::is_synchronous(master_.state()) && !master_.silent(); }
  /// In active operation a telegram comes before the look at what was received: it is punctual.
  bool looks_before_sending() const noexcept { return !cansync::is_active(master_.state()); }
  bool looks_before_edge() const noexcept;
  bool stopping() const noexcept { return stop_.load(std::memory_order_relaxed); }
  void decide_stop() noexcept;
  void follow_sync() noexcept;
  void watch_sync_device(bool output, int error, int& known) noexcept;

  can::Bus& bus_;
  Exchange& exchange_;
  const LoopSettings loop_;
  const can::Time interval_;
  WallClock clock_;
  Reporter reporter_;
  std::optional<cansync::Master> own_master_;  ///< without a cluster
  cansync::Master& master_;
  ModeControl mode_;
  RequestIntake requests_;
  std::atomic<bool> stop_{false};
  std::atomic<bool> stop_asked_{false};  ///< by `request_stop_unless_active`; cleared when decided
  StartTarget target_at_stop_ = StartTarget::none;
  std::atomic<std::uint64_t> wake_ups_{0};

  Timeline timeline_;
  SyncSnapshot line_;  ///< the SYNC line
  int sync_output_error_ = 0;
  int sync_input_error_ = 0;
  cansync::IntervalNumber number_ = 0;  ///< the running interval
  bool begun_ = false;                  ///< the running interval began with an edge
  can::Time sync_{};                    ///< edge of the running interval, as due
  rt::TimingStatistics lateness_;
  BusLoad load_;
  SlotStatistics slots_;
  std::uint64_t missed_syncs_ = 0;
  std::array<std::uint64_t, cansync::kSlots> left_out_ = {};
  can::Time next_second_{};
  BusWatch watch_;
  can::Time second_master_since_{0};  ///< wall clock since when another master sends; 0: none does
  std::uint64_t lost_frames_ = 0;     ///< of the controller, when the running second began
  can::Frame last_sent_;
  bool looked_ = false;        ///< for frames, since the last sleep
  bool echo_due_ = false;      ///< `last_sent_` was not seen on the bus yet
  bool heard_others_ = false;  ///< somebody else's frame came in this interval
};

}  // namespace cansyncd
