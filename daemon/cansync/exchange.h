#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <variant>

#include "can/bus.h"
#include "can/link_facts.h"
#include "cansync/channel/jobs.h"
#include "cansync/master.h"
#include "cansync/process_data/release_status.h"
#include "cansync/settings/mode.h"
#include "cansync/settings/settings.h"
#include "cansync/settings/settings_in_force.h"
#include "daemon/cansync/slot_statistics.h"
#include "daemon/loop/moment.h"
#include "daemon/loop/sync_snapshot.h"
#include "rt/latest_value.h"
#include "rt/spsc_ring.h"
#include "rt/wake_signal.h"
#include "sync/phase_lock.h"

/// Everything the realtime thread and the gateway thread share, and nothing else is shared between them. One
/// value comes from the thread that watches the bus's interface.
///
/// The gateway writes `requests` and reads the rest; the realtime thread the other way round. All of it is
/// bounded, allocated at the start and wait-free on both sides.
namespace cansyncd {

// --- gateway -> realtime thread

/// Ends an open job as `cancelled`. No reply of its own: the job answers. An unknown job is ignored.
struct Cancel {
  cansync::JobId id = 0;
};

/// Withdraws the reference values of a telegram (their writer is gone or silent). No reply.
struct StopRelease {
  cansync::Channel channel = cansync::Channel::one;
  std::uint32_t hold = 0;  ///< intervals for which the last values go on before the release stops
};

/// What an operator asks of the whole line.
enum class Mode : std::uint8_t {
  set_up,     ///< SYNC and command channel run, no process data; from every state
  run,        ///< active operation; only from set-up (else Refusal::wrong_state)
  stop,       ///< no SYNC, nothing on the bus; open jobs end as master_stopped
  reset_can,  ///< resets the CAN controller, which leaves bus-off; the state stays
  restart,    ///< cold restart, then to the configured start target
};

/// Changes the mode; answered with CommandDone when it has taken effect, or Refused.
struct ModeRequest {
  cansync::JobId id = 0;
  Mode mode = Mode::set_up;
  bool force = false;  ///< run: also when slaves are missing
};

/// Changes which slaves are asked for actual values; what is empty stays as it is. One reply.
struct SetPolling {
  cansync::JobId id = 0;
  std::array<std::optional<cansync::Cursor>, cansync::kChannels> polling = {};
  std::optional<cansync::SlaveNumber> maximum_slave;
};

/// Changes the cursors of the command channel; what is empty stays as it is. One reply.
struct SetCursors {
  cansync::JobId id = 0;
  std::optional<cansync::Cursor> control_word;
  std::optional<cansync::Cursor> parameter;
  std::optional<cansync::Cursor> transfer;
};

/// Changes the mapping of WRC1 and WRC2. One reply.
struct SetReferenceMapping {
  cansync::JobId id = 0;
  cansync::ProcessMapping mapping = {};
};

/// Changes the mapping of one slave's RDC1 and RDC2. One reply.
struct SetActualMapping {
  cansync::JobId id = 0;
  cansync::SlaveNumber slave;
  cansync::ProcessMapping mapping = {};
};

/// Changes the limits of one reference value. One reply.
struct SetReferenceLimits {
  cansync::JobId id = 0;
  std::uint8_t value = 0;
  cansync::ReferenceLimits limits;
};

/// Lets a slave that is held out be used again. One reply.
struct ReleaseSlave {
  cansync::JobId id = 0;
  cansync::SlaveNumber slave;
  bool force = false;  ///< without its list of parameters
};

/// A request of the gateway. Those with a JobId get exactly one `Terminal`. A transfer's data belongs to the
/// realtime thread from the push until its terminal was popped. ReferenceUpdate is answered only when it is
/// refused (`ReferenceRefused`).
using Request = std::variant<cansync::ParameterRequest, cansync::TransferRequest, cansync::ControlWordRequest,
                             cansync::BroadcastRequest, cansync::ReferenceUpdate, Cancel, StopRelease,
                             ModeRequest, SetPolling, SetCursors, SetReferenceMapping, SetActualMapping,
                             SetReferenceLimits, ReleaseSlave>;

// --- realtime thread -> gateway: never lost

/// A parameter job ended.
struct ParameterDone {
  cansync::JobId id = 0;
  cansync::ParameterResult result;
};

/// A transfer ended; its data belongs to the gateway again.
struct TransferDone {
  cansync::JobId id = 0;
  cansync::TransferResult result;
};

/// A control word or broadcast was seen on the bus, or a mode, polling, cursor or mapping command took
/// effect.
struct CommandDone {
  cansync::JobId id = 0;
  cansync::Outcome outcome = cansync::Outcome::done;
};

/// A request was not taken; nothing was sent.
struct Refused {
  cansync::JobId id = 0;
  cansync::Refusal refusal = cansync::Refusal::none;
};

/// The one answer to a request with a JobId.
using Terminal = std::variant<ParameterDone, TransferDone, CommandDone, Refused>;

// --- realtime thread -> gateway: counted as `lost_reports` when there is no room

/// The master changed its state.
struct StateChanged {
  Moment when;
  cansync::State from = cansync::State::start_up;
  cansync::State to = cansync::State::start_up;
  cansync::ControlCommand command = cansync::ControlCommand::cold_restart;
};

/// A running transfer came further.
struct TransferProgress {
  cansync::JobId id = 0;
  std::uint32_t bytes = 0;  ///< transferred and confirmed so far
};

/// The master has something for the journal.
struct EventReport {
  Moment when;
  cansync::MasterEvent event{cansync::MasterEvent::Code::slave_responds, std::nullopt, 0};
};

/// Reference values were not taken.
struct ReferenceRefused {
  Moment when;
  cansync::Channel channel = cansync::Channel::one;
  cansync::Refusal refusal = cansync::Refusal::none;
  cansync::LimitViolation beyond = {};  ///< of Refusal::beyond_limit
};

/// SYNC edges were skipped because the thread came too late; none is made up for.
struct SyncsMissed {
  Moment when;              ///< the first edge produced again
  std::uint64_t count = 0;  ///< edges skipped in a row
};

/// The CAN controller changed its state.
struct ControllerChanged {
  Moment when;
  can::ControllerState from = can::ControllerState::error_active;
  can::ControllerState to = can::ControllerState::error_active;
};

/// Handing telegrams to the bus began to fail, or works again. Reported on the edge.
struct SendingChanged {
  Moment when;
  can::SendResult result = can::SendResult::queued;  ///< `queued`: works again
  std::uint64_t failed = 0;                          ///< when it works again: telegrams that failed meanwhile
};

/// The timeline and what it follows: locked, holding over, lost, found again. Reported on the edge.
struct SyncSourceChanged {
  Moment when;
  sync_line::LockState from = sync_line::LockState::searching;
  sync_line::LockState to = sync_line::LockState::searching;
  can::Time missing{0};  ///< for how long edges have been (to locked: had been) missing
};

/// A device of the SYNC line began to fail, or works again. Reported on the edge.
struct SyncDeviceChanged {
  Moment when;
  bool output = false;         ///< false: the input
  int error = 0;               ///< an errno; SyncLine::kNotSent: the bus took no frame; 0: works again
  std::uint64_t failures = 0;  ///< edges that could not be made since the start
};

/// The interface of the bus came, went, or was set up differently. Reported on the edge.
struct LinkChanged {
  Moment when;
  can::LinkState from = can::LinkState::up;
  can::LinkState to = can::LinkState::up;
  std::uint32_t bits_per_second = 0;  ///< bit rate it is set to; 0: not known
  std::uint64_t left_out = 0;         ///< up again: telegrams that could not be sent meanwhile
};

/// Telegrams that were handed over do not come on the bus, or do again. Reported on the edge.
struct DeliveryChanged {
  Moment when;
  can::Delivery from = can::Delivery::normal;
  can::Delivery to = can::Delivery::normal;
  std::uint64_t never_sent =
      0;                       ///< to normal: telegrams that were handed over meanwhile and never on the bus
  std::uint64_t left_out = 0;  ///< to normal: telegrams that were not handed over
};

/// What can go wrong on a bus again and again.
enum class BusFaultKind : std::uint8_t {
  not_acknowledged,  ///< a telegram was acknowledged by nobody
  error_frames,      ///< error frames of any kind
  overrun,           ///< the controller lost received frames
  dropped,           ///< received frames were not taken from the kernel in time
};
inline constexpr unsigned kBusFaultKinds = 4;

/// A fault of the bus began, or stayed away for a while. Counted in between.
struct BusFault {
  Moment when;
  BusFaultKind kind = BusFaultKind::not_acknowledged;
  bool over = false;
  std::uint64_t count = 0;  ///< how often: so far, or when over, altogether
};

using Report = std::variant<StateChanged, TransferProgress, EventReport, ReferenceRefused, SyncsMissed,
                            ControllerChanged, SendingChanged, SyncSourceChanged, SyncDeviceChanged,
                            LinkChanged, BusFault, DeliveryChanged>;

// --- realtime thread -> gateway: newest value only

/// Actual values of one slave; written for every actual value telegram that arrives.
struct ActualReport {
  cansync::ActualValues values;
  Moment when;  ///< end of the newest telegram
};

/// Status of one slave; written on every change of responds, synchronized or status word, and about once a
/// second for the counters.
struct SlaveReport {
  cansync::SlaveStatus status;
  Moment when;
};

/// Start of an interval; written right after each SYNC edge when switched on.
struct IntervalReport {
  Moment sync;                    ///< the edge, as due
  cansync::Duration time_left{};  ///< from the edge until the reference values are taken
};

/// State of the master; written every interval, without waking the gateway for it.
struct MasterSnapshot {
  Moment when;
  cansync::State state = cansync::State::start_up;
  std::uint16_t cansync_status = 0;  ///< w_CANsync_STATUS: bit 1 overrun, 2 send buffer free, 3 last send
                                     ///< successful, 4 receiving, 5 sending, 6 warning, 7 bus-off
  cansync::MasterCounters counters;
  can::ControllerStatus controller;
  cansync::SlaveMask configured;
  cansync::SlaveMask responding;
  cansync::SlaveMask synchronized;
  cansync::SlaveMask released;
  cansync::SlaveMask wrong;      ///< held: not the drive expected
  cansync::SlaveMask duplicate;  ///< two drives answer
  cansync::SlaveMask unknown;    ///< answer and are not configured
  std::uint32_t open_parameter_jobs = 0;
  std::uint32_t open_transfers = 0;
  std::uint64_t missed_syncs = 0;
  std::uint64_t lost_reports = 0;
  SyncSnapshot sync;
  std::array<cansync::ReleaseStatus, cansync::kChannels> release = {};  ///< of the reference values
  std::array<bool, cansync::kChannels> lead_axis = {};  ///< the lead axis of a cluster gives them
  bool second_master = false;                           ///< another master has sent within the last 3 s
  std::uint32_t second_master_identifier = 0;           ///< of its newest frame; 0: none, or a SYNC
  can::Time second_master_since{0};                     ///< wall clock; 0: no other master sends
  cansync::BusAccess access = cansync::BusAccess::granted;
  bool waits_for_command = false;  ///< because another master was on the bus
  bool waits_for_upper_sync =
      false;  ///< the lower bus of a cluster, whose upper bus has no SYNC that is followed
  can::TimestampSource timestamps = can::TimestampSource::thread;
};

/// Settings in force; written at the start and after each change.
struct SettingsSnapshot : cansync::SettingsInForce {
  std::uint64_t mapping_number = 1;  ///< of the reference mapping
};

/// How punctual the realtime thread is; written once a second of bus time.
struct TimingSnapshot {
  std::uint64_t intervals = 0;                   ///< since the start
  cansync::Duration lateness_minimum{};          ///< SYNC wake-up after it was due, of the last second
  cansync::Duration lateness_mean{};             ///< likewise
  cansync::Duration lateness_maximum{};          ///< likewise
  std::array<std::uint64_t, 16> histogram = {};  ///< since the start; bucket n: under 2^n us, last: the rest
  cansync::Duration lateness_sum{};              ///< since the start
  std::array<std::uint64_t, cansync::kSlots> left_out = {};  ///< WRC1, WRC2, CC since the start
  std::uint64_t missed_syncs = 0;                            ///< since the start
  std::uint32_t bus_load = 0;                                ///< permille, of the last second
  SlotSummaries slots = {};                                  ///< as seen on the bus, in active operation
  std::array<cansync::Duration, cansync::kSlots> planned =
      {};  ///< planned start of WRC1, WRC2, CC after SYNC
};

/// Number of entries in each queue of the exchange.
struct ExchangeSizes {
  std::size_t requests = 256;
  std::size_t terminals = 1024;  ///< at least the open jobs the master can hold; `terminals_for` tells
  std::size_t reports = 1024;
};

/// Terminal answers that can be due at once with these settings: every open job, and every request that still
/// waits in a queue of `requests` entries when the master stops.
constexpr std::size_t terminals_for(const cansync::CommandChannelSettings& channel,
                                    std::size_t requests = ExchangeSizes{}.requests) noexcept {
  constexpr std::size_t kBroadcastPriorities = 3;
  constexpr std::size_t kControlWords = cansync::kSlaves;  // one of each slave waits
  constexpr std::size_t kOnTheWay = 1;                     // handed over, and its echo not yet seen
  return std::size_t{channel.parameter_queue} + channel.transfer_queue + kControlWords +
         kBroadcastPriorities * channel.broadcast_queue + kOnTheWay + requests;
}

/// The shared structures. Constructed before both threads, destroyed after both.
///
/// The realtime thread takes a request only while `terminals` has room for the answer of every request it
/// has taken: a gateway that does not read makes `requests` fill up, and then it has to refuse
/// (`queue_full`) what it cannot push. No terminal can be lost. What still waits when the realtime thread
/// stops is answered as `master_stopped`, as far as there is room; once that thread has ended, whatever is
/// left in `requests` was never begun, and the gateway may pop it and answer for it.
struct Exchange {
  explicit Exchange(const ExchangeSizes& sizes)
      : requests(sizes.requests), terminals(sizes.terminals), reports(sizes.reports) {}

  rt::SpscRing<Request> requests;    ///< gateway -> realtime; looked at once an interval and slot
  rt::SpscRing<Terminal> terminals;  ///< realtime -> gateway
  rt::SpscRing<Report> reports;      ///< realtime -> gateway, lossy

  std::array<rt::LatestValue<ActualReport>, cansync::kSlaves> actual;
  std::array<rt::LatestValue<SlaveReport>, cansync::kSlaves> slave;
  rt::LatestValue<IntervalReport> interval;
  rt::LatestValue<MasterSnapshot> master;
  rt::LatestValue<SettingsSnapshot> settings;
  rt::LatestValue<TimingSnapshot> timing;
  rt::LatestValue<can::LinkFacts> link;  ///< written by the thread that watches the interface

  rt::WakeSignal gateway_wake;  ///< signalled when anything above was written for the gateway
};

}  // namespace cansyncd
