#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <variant>

#include "can/bus.h"
#include "can/job_ending.h"
#include "can/link_facts.h"
#include "cansync/cluster/cluster.h"
#include "cansync/settings/mode.h"
#include "cansync/slave/block_area.h"
#include "cansync/slave/parameter_jobs.h"
#include "cansync/slave/slave.h"
#include "cansync/slave/slave_supervision.h"
#include "cansync/telegram/telegram.h"
#include "cansync_slave/received_values.h"
#include "daemon/loop/moment.h"
#include "daemon/loop/sync_snapshot.h"
#include "rt/latest_value.h"
#include "rt/spsc_ring.h"
#include "rt/wake_signal.h"

/// Everything that the realtime thread of a slave and its gateway thread share. The gateway writes
/// `releases`, `orders` and `commands`, and reads the rest; the realtime thread the other way round. All of
/// it is bounded, allocated at the start and wait-free on both sides.
namespace cansyncd {

using cansync_slave::ReceivedValues;

/// A reference value telegram with values came.
struct ReferencesReport {
  ReceivedValues values;
};

/// An actual value telegram of another slave came.
struct MonitoredReport {
  cansync::SlaveNumber slave;
  ReceivedValues values;
};

/// What an action is to the slave.
enum class SlaveAction : std::uint8_t { control_word, sync_mode, user };

/// An action of the master that names this slave.
struct ActionReport {
  Moment when;
  SlaveAction kind = SlaveAction::user;
  cansync::ActionCommand action;
  std::uint64_t number = 0;  ///< counted since the start
};

/// The slave went from one operating state to another.
struct SlaveStateReport {
  Moment when;
  cansync::State from = cansync::State::start_up;
  cansync::State to = cansync::State::start_up;
};

/// The slave became synchronized, or is no longer.
struct SynchronizedReport {
  Moment when;
  bool synchronized = false;
};

/// How well the intervals follow the SYNC input has changed.
struct LockReport {
  Moment when;
  sync_line::LockState to = sync_line::LockState::searching;
  can::Time missing{0};  ///< for how long edges have been (to locked: had been) missing
};

/// The device of the SYNC input began to fail, or works again.
struct InputReport {
  Moment when;
  int error = 0;  ///< an errno; 0: it works
};

/// The supervision has found a fault, or it is over.
struct FaultReport {
  Moment when;
  cansync::SlaveFault fault = cansync::SlaveFault::none;
  cansync::SlaveReaction reaction = cansync::SlaveReaction::report;
  bool over = false;
};

/// A frame of another node came with an identifier of this slave: its number is given twice.
struct OwnNumberReport {
  Moment when;
  std::uint32_t identifier = 0;
};

using SlaveSideReport = std::variant<ReferencesReport, MonitoredReport, SlaveStateReport, SynchronizedReport,
                                     LockReport, InputReport, FaultReport, OwnNumberReport>;

/// Actual values that an application releases, for one telegram.
struct ReleaseOrder {
  cansync::Channel channel = cansync::Channel::one;
  std::array<std::uint32_t, cansync::kWords> values = {};  ///< of this channel
  std::uint8_t valid = 0;                                  ///< bit n: value n is new
  std::uint32_t intervals = 0;  ///< for which it waits to be asked for; 0: what waits is withdrawn
};

/// Of a parameter job of an application.
struct JobReport {
  enum class Step : std::uint8_t { asked, dropped, answered };
  Moment when;
  Step step = Step::asked;
  cansync::AskedParameter job;  ///< all of it when it is asked, else its id
};

/// Of a block of an application.
struct BlockReport {
  enum class Step : std::uint8_t {
    begun,     ///< waits to be allowed
    complete,  ///< a whole download: `data`
    telegram,  ///< one telegram: `offset`, `bytes`, of a download `data`
    ended,
  };
  Moment when;
  Step step = Step::begun;
  cansync::AskedBlock block;  ///< when it ends, its id
  cansync::BlockEnd end = cansync::BlockEnd::done;
  std::uint16_t offset = 0;
  std::uint16_t bytes = 0;
  std::array<std::uint8_t, cansync::kBlockAreaBytes> data = {};
};

using ServiceReport = std::variant<JobReport, BlockReport>;

/// An application is there and has taken over numbers, or it is gone.
struct TakeOver {
  bool present = false;
  bool same_application = false;  ///< as the one before: what is open stays
  bool blocks = false;            ///< it takes uploads and downloads
  cansync::TakenOver taken;
};

/// Its answer to a parameter job.
struct JobAnswer {
  std::uint64_t id = 0;
  cansync::ParameterAnswer answer;
};

/// What it says to a block.
struct BlockReply {
  enum class Kind : std::uint8_t { allow, refuse, take, step };
  Kind kind = Kind::allow;
  std::uint64_t id = 0;
  cansync::TransferError error = cansync::TransferError::none;
  std::uint16_t length = 0;  ///< allow: of an upload telegram by telegram
  std::uint16_t bytes = 0;   ///< of `data`
  std::array<std::uint8_t, cansync::kBlockAreaBytes> data = {};
};

/// What the slave is to do; SlaveMode of the data model.
enum class SlaveMode : std::uint8_t { setup, run, stop, restart, reset_can };

/// A program sets the slave's mode.
struct SlaveModeOrder {
  std::uint64_t id = 0;
  SlaveMode mode = SlaveMode::setup;
};

/// A program sets this slave's own mapping.
struct SlaveMappingOrder {
  std::uint64_t id = 0;
  cansync::ProcessMapping reference = {};
  cansync::ProcessMapping actual = {};
};

/// A program says how the actual values of another slave are listened to.
struct SlaveListenOrder {
  std::uint64_t id = 0;
  cansync::SlaveNumber other;
  std::optional<cansync::ProcessMapping> mapping;  ///< nothing: not any more
};

using SlaveOrder = std::variant<SlaveModeOrder, SlaveMappingOrder, SlaveListenOrder>;

/// Why the slave did not do it.
enum class SlaveRefusal : std::uint8_t {
  none,
  wrong_state,      ///< the mode does not follow from the state
  of_cluster,       ///< its file says how it is
  not_permitted,    ///< the daemon may not reset the controller
  no_controller,    ///< it cannot be reset
  reset_under_way,  ///< already
};

/// The one answer to an order, with the order.
struct SlaveOrderDone {
  SlaveOrder order;
  SlaveRefusal refusal = SlaveRefusal::none;
  std::optional<can::JobKnown> stopped = {};  ///< the slave was stopped before its end: what is known of it
};

using ApplicationOrder = std::variant<TakeOver, JobAnswer, BlockReply>;

/// What is counted of the jobs and blocks that an application is asked for.
struct ServiceCounters {
  std::uint64_t jobs = 0;
  std::uint64_t jobs_answered = 0;  ///< the application's answer was on the bus
  std::uint64_t jobs_dropped = 0;
  std::uint64_t blocks = 0;
  std::uint64_t blocks_done = 0;
  std::uint64_t answers_unused = 0;  ///< of the application, to what was not open any more
  std::uint64_t lost = 0;            ///< reports to it for which there was no room
};

/// What is counted of the slave's answers, beside what the slave counts itself.
struct AnswerCounters {
  std::uint64_t failed = 0;       ///< not taken by the bus
  can::Time response_last{0};     ///< from when it could go out to its being handed over
  can::Time response_longest{0};  ///< likewise
  can::Time margin_least{0};      ///< least time that was left to an RDC; 0 before the first
};

/// What a cluster tells beside its slave and its master.
struct ClusterSnapshot {
  cansync::ClusterState state = cansync::ClusterState::stopped;
  cansync::SubSlave own_number;
  cansync::GatewayCounters jobs;
  std::uint64_t sync_losses = 0;
  std::array<cansync::LeadCounters, cansync::kChannels> lead = {};
};

/// State of the slave; written when it changes and ten times a second.
struct SlaveSnapshot {
  can::ControllerStatus controller;
  can::TimestampSource timestamps = can::TimestampSource::thread;
  SyncSnapshot sync;
  cansync::State state = cansync::State::start_up;
  std::uint16_t cansync_status = 0;
  std::uint16_t status_word = 0;
  bool activated = false;
  std::uint8_t sync_mode = 0;  ///< data byte of the newest action "SYNC mode"
  bool synchronized = false;
  cansync::SlaveFault fault = cansync::SlaveFault::none;
  cansync::SlaveReaction reaction = cansync::SlaveReaction::report;
  bool traffic = false;  ///< telegrams came within the last second
  IntervalNumber interval = 0;
  std::uint64_t missing_edges = 0;
  std::uint32_t missing_in_row = 0;
  std::uint64_t missing_references = 0;
  std::array<std::uint64_t, cansync::kChannels> reference_telegrams = {};
  std::array<cansync::ActualCounters, cansync::kChannels> actual = {};
  std::array<std::uint64_t, cansync::kChannels> released = {};  ///< by applications
  std::array<std::uint64_t, cansync::kChannels> unused = {};    ///< of those: never asked for
  cansync::ResponseCounters responses;
  AnswerCounters answers;
  ServiceCounters service;
  std::uint64_t actions = 0;
  std::uint64_t own_number_frames = 0;
  std::uint64_t lost_references = 0;       ///< reference value telegrams that had no room in `reports`
  std::uint64_t lost_reports = 0;          ///< all reports that had none
  std::uint32_t bus_load = 0;              ///< permille, of the last second
  std::optional<ClusterSnapshot> cluster;  ///< the slave is that of a cluster
};

/// The shared structures. Constructed before both threads, destroyed after both.
struct SlaveExchange {
  /// `report_queue`: entries of `reports`.
  explicit SlaveExchange(std::size_t report_queue)
      : releases(kReleases),
        orders(kOrders),
        commands(kCommands),
        done(kCommands),
        reports(report_queue),
        actions(kActions),
        jobs(kJobs) {}

  static constexpr std::size_t kReleases = 64;
  static constexpr std::size_t kOrders = 16;
  /// Of `commands`, and so many answers at most: the desk hands on no more before it has those.
  static constexpr std::size_t kCommands = 16;
  static constexpr std::size_t kActions = 256;
  static constexpr std::size_t kJobs = 64;  ///< one parameter job and one block are open at a time

  rt::SpscRing<ReleaseOrder> releases;    ///< gateway -> realtime
  rt::SpscRing<ApplicationOrder> orders;  ///< gateway -> realtime
  rt::SpscRing<SlaveOrder> commands;      ///< gateway -> realtime
  rt::SpscRing<SlaveOrderDone> done;      ///< realtime -> gateway
  rt::SpscRing<SlaveSideReport> reports;  ///< realtime -> gateway, lossy
  /// realtime -> gateway, lossy; of its own, so that process data take no room from a control word
  rt::SpscRing<ActionReport> actions;
  /// The newest control word for which `actions` had no room; written before what comes after it.
  rt::LatestValue<ActionReport> lost_control_word;
  rt::SpscRing<ServiceReport> jobs;  ///< realtime -> gateway, lossy: what is lost ends by its time
  rt::LatestValue<SlaveSnapshot> status;
  rt::LatestValue<can::LinkFacts> link;  ///< of the thread that watches the interface
  rt::WakeSignal gateway_wake;           ///< signalled when anything above was written for the gateway
};

}  // namespace cansyncd
