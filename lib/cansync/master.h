#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>

#include "can/frame.h"
#include "cansync/channel/jobs.h"
#include "cansync/process_data/release_status.h"
#include "cansync/settings/mode.h"
#include "cansync/settings/settings.h"
#include "cansync/supervision/slave_state.h"
#include "cansync/supervision/sole_master.h"
#include "cansync/supervision/strays.h"
#include "cansync/telegram/mapping.h"
#include "cansync/telegram/numbers.h"
#include "cansync/telegram/telegram.h"

namespace cansync {

/// The master's sending slots of one interval, in their order.
enum class Slot : std::uint8_t { reference_one, reference_two, command };
inline constexpr unsigned kSlots = 3;

/// Actual values of one slave as the master knows them.
struct ActualValues {
  Values value = {};
  std::array<bool, kChannels> arrived = {};             ///< which telegram brought this update
  std::array<IntervalNumber, kChannels> interval = {};  ///< interval in which each telegram came last
  std::array<std::uint64_t, kChannels> count = {};      ///< telegrams so far; 0 = never
  std::uint8_t words = 0;  ///< bit n: value n came as its low word alone, 16 bits
};

/// Counters since the start of the master.
struct MasterCounters {
  std::uint64_t intervals = 0;       ///< begun; those that were skipped do not count
  std::uint64_t telegrams_sent = 0;  ///< handed to the bus, of all slots
  std::uint64_t left_out = 0;  ///< telegrams left out because their slot had passed or the bus refused them
  std::uint64_t references_not_released =
      0;  ///< active intervals x channels without released reference values
  std::array<std::uint64_t, kDecodeErrors> rejected = {};  ///< received frames by DecodeError
  std::uint64_t unexpected = 0;  ///< well-formed telegrams of slaves that were not taken, of every kind
  std::array<std::uint64_t, kUnexpectedKinds> unexpected_by_kind = {};  ///< the same by Unexpected
  std::uint64_t second_master = 0;  ///< frames with a master's identifier that somebody else has sent
};

/// Something worth a line in the journal. `code` says what the numbers mean.
struct MasterEvent {
  /// What happened; beside each: which members are set and what `detail` means.
  enum class Code : std::uint8_t {
    slave_responds,          ///< slave: answers for the first time
    slave_lost,              ///< slave; detail: jobs that ended because of it
    slave_synchronized,      ///< slave
    slave_not_synchronized,  ///< slave
    all_synchronized,
    references_stopped,   ///< detail: channel 1 or 2
    references_released,  ///< detail: channel 1 or 2
    references_too_old,   ///< detail: channel 1 or 2; expected: newer ones within so many intervals, 0:
                          ///< release before `ReferenceUpdate::too_old_from`
    references_held,      ///< still released for a limited time; detail: channel 1 or 2
    second_master,        ///< detail: identifier of its first frame, 0: a SYNC; found: `BusAccess` since then
    second_master_gone,   ///< nothing of it for 3 s; detail: how many frames there were
    slave_returned,       ///< slave: answers again
    slave_checked,        ///< slave; detail: parameters that have their value
    slave_check_failed,   ///< slave; detail: parameter number, `expected`, `found` and `outcome`
    slave_released,       ///< slave: no longer held out; detail: 1 = by command, unchecked
    slave_identified,     ///< slave: the drive expected; detail: parameters that have their value
    wrong_drive,      ///< slave: not the drive expected; detail: parameter number, `expected`, `found` and
                      ///< `outcome`
    duplicate_slave,  ///< slave: it answers more often than it is asked, so there are two drives
    unknown_slave,    ///< slave: answers and is not configured
    slave_status_refused,  ///< slave: answers the read of its status word with an error (found: the code), or
    ///< for 5 s with busy (outcome `timeout`) or with no word (`no_answer`), so whether
    ///< it is synchronized cannot be known; detail: parameter number
  };
  Code code;
  std::optional<SlaveNumber> slave;
  std::uint32_t detail = 0;         ///< meaning and unit: see `Code`
  std::uint32_t expected = 0;       ///< raw value
  std::uint32_t found = 0;          ///< raw value; with Outcome::slave_error the slave's code
  Outcome outcome = Outcome::done;  ///< done: `found` is another value
  friend bool operator==(const MasterEvent&, const MasterEvent&) = default;
};
/// A stable word for a code, e.g. "slave_lost"; the text lives as long as the program.
std::string_view name(MasterEvent::Code code) noexcept;

/// What is known of one slave (M 3.2.2.7).
struct SlaveStatus {
  bool configured = false;
  bool responds = false;            ///< bit 0 of the slave status
  bool synchronized = false;        ///< bit 1: bit 15 of its status word
  std::uint16_t status_word = 0;    ///< last status word read
  bool status_known = false;        ///< a status word was read since the slave last began to respond
  std::uint16_t status_error = 0;   ///< code with which it refused its status word last; 0: it gave it
  IntervalNumber last_seen = 0;     ///< interval of its last telegram of any kind
  std::uint64_t answers = 0;        ///< to commands, since the start of the master
  std::uint64_t unanswered = 0;     ///< commands without an answer
  std::uint64_t missed_actual = 0;  ///< asked for actual values, none came in that interval
  std::uint64_t slow_answers = 0;   ///< later than tRSPTO
  Duration last_response{0};        ///< end of the command to end of the answer, of the last answer
  Duration longest_response{0};
  SlaveState state = SlaveState::absent;
  std::optional<MasterEvent> held;   ///< in state `held`: the event that says why
  std::uint64_t times_lost = 0;      ///< stopped answering, alone or because the bus was gone
  std::uint64_t times_returned = 0;  ///< answered again
  std::uint64_t jobs_ended = 0;      ///< jobs that ended because it stopped answering

  /// Slave status register: bit 0 responds, bit 1 synchronized.
  constexpr std::uint16_t slave_register() const noexcept {
    return static_cast<std::uint16_t>((responds ? 1u : 0u) | (synchronized ? 2u : 0u));
  }
};

/// Receives what the master has to tell. Called from inside the master's functions, on their thread; must not
/// allocate, lock, throw, or call the master.
class MasterListener {
 public:
  virtual ~MasterListener() = default;
  /// An actual value telegram of this slave was taken; `arrived` says which. `values` lives during the call.
  virtual void actual_values(SlaveNumber slave, const ActualValues& values) noexcept = 0;
  /// What is known of a slave has changed, or set-up begins; counters of answers alone do not bring it.
  virtual void slave_status(SlaveNumber slave, const SlaveStatus& status) noexcept = 0;
  /// A command of the control register was obeyed (M 3.2.2.3), also when `from` and `to` are equal; never for
  /// `reset_can`, which keeps the state.
  virtual void state_changed(State from, State to, ControlCommand command) noexcept = 0;
  /// A parameter job has ended; said once for each that was taken. `result` lives during the call.
  virtual void parameter_done(JobId id, const ParameterResult& result) noexcept = 0;
  /// Bytes transferred and confirmed so far; fewer than before when a block is begun anew.
  virtual void transfer_progress(JobId id, std::uint32_t bytes) noexcept = 0;
  /// A transfer has ended, and the master no longer touches its data; said once for each that was taken.
  virtual void transfer_done(JobId id, const TransferResult& result) noexcept = 0;
  /// A control word or broadcast was seen on the bus (`done`), or ended otherwise.
  virtual void command_done(JobId id, Outcome outcome) noexcept = 0;
  /// Something for the journal has happened; `event` lives during the call.
  virtual void event(const MasterEvent& event) noexcept = 0;
  /// Reference values were due and are refused whole, because one is beyond a limit; said for each update.
  /// Without need to know: nothing happens.
  virtual void reference_beyond_limit(Channel /*channel*/, const LimitViolation& /*beyond*/) noexcept {}
};

/// The CANsync master, sans-IO: it is told what happened and when, and asked what to send.
///
/// One interval: `begin_interval` at the SYNC edge; for each slot in order, at its planned start, `take`,
/// then either `sent` or `left_out`; `receive` for every frame as it comes. Frames of one interval may come
/// before or after any of the master's own telegrams.
///
/// Missed-tick rule: interval numbers may jump; what was missed is skipped and counted, never caught up.
///
/// All memory is taken in the constructor. Every other function neither allocates, blocks nor throws, and is
/// realtime safe. Not thread safe: one thread owns the master.
class Master {
 public:
  /// `listener` must outlive the master. Settings must have passed `check` (settings_check.h).
  Master(const MasterSettings& settings, MasterListener& listener);
  ~Master();
  Master(const Master&) = delete;
  Master& operator=(const Master&) = delete;

  // --- the interval

  /// SYNC edge number `n` was produced. Numbers rise; a jump means missed edges.
  void begin_interval(IntervalNumber n) noexcept;
  /// Instead, while there is no synchronous operation or the master is `silent`: interval `n` passes without
  /// an edge. What is given now has its time from now on.
  void pass_interval(IntervalNumber n) noexcept;

  /// When to hand over this slot's telegram, after SYNC: some margin before its latest start. In set-up,
  /// where no reference values are on the bus, the command goes out early so that its answer comes in the
  /// same interval.
  Duration planned_start(Slot slot) const noexcept;

  /// Latest start of this slot's telegram, after SYNC.
  Duration latest_start(Slot slot) const noexcept;

  /// The frame for this slot, if there is one to send in this interval. Ask once per slot and interval.
  std::optional<can::Frame> take(Slot slot) noexcept;

  /// The frame of `take` was handed to the bus.
  void sent(Slot slot) noexcept;

  /// The frame of `take` could not be sent in this slot: reference values are dropped, a command waits for
  /// its next turn.
  void left_out(Slot slot) noexcept;

  /// The master's own frame was on the bus until `since_sync` (after the running interval's edge). Must be
  /// told of every frame in the order of the bus: answers that come before it are not taken for answers to
  /// it. A control word or broadcast that was not told of when the next command is taken ends as `no_answer`.
  void transmitted(const can::Frame& frame, Duration since_sync) noexcept;

  /// A frame of somebody else arrived at `since_sync` (after the running interval's edge).
  void receive(const can::Frame& frame, Duration since_sync) noexcept;

  /// A SYNC that is not the master's own was on the bus: another master sends.
  void other_sync() noexcept;

  /// The interface is gone or down, the controller off the bus for long, or nobody acknowledges: no slave responds until it has answered again, and then it is activated
  /// anew. The state stays, and so do open jobs. Reference values that were given before are not released when
  /// it is back.
  void bus_lost() noexcept;

  /// Nothing can be received: from now on the master is silent.
  void bus_away() noexcept;
  /// Frames can be received again: the master listens anew before its next frame.
  void bus_returned() noexcept;

  // --- requests: a refusal means nothing was done

  /// Takes a request; the listener is told of its end under its id, for a command that is replaced at once
  /// within this call. A refusal says why it was not taken: `wrong_state` outside synchronous operation, for
  /// reference values outside active operation, else see `Refusal`.
  Refusal submit(const ParameterRequest& request) noexcept;
  Refusal submit(const TransferRequest& request) noexcept;
  Refusal submit(const ControlWordRequest& request) noexcept;
  Refusal submit(const BroadcastRequest& request) noexcept;
  Refusal submit(const ReferenceUpdate& update) noexcept;

  /// Ends an open job as `cancelled`; a running transfer is cancelled on the slave first.
  Refusal cancel(JobId id) noexcept;

  /// Lets a slave that is held out be used again. Without `force` what tells who it is, and its list of
  /// parameters, are gone through again. With `force` the slave counts as the drive expected, also when two
  /// drives answer, until it is lost or loses SYNC; one that is synchronized is released immediately. A slave that is not synchronized is
  /// activated again.
  Refusal release(SlaveNumber slave, bool force) noexcept;

  /// Withdraws reference values not yet sent; the telegram is no longer released until new ones come. With
  /// `hold`, a running release goes on with its last values for so many intervals before it stops; one that
  /// has stopped is not taken up again.
  void stop_release(Channel channel, std::uint32_t hold = 0) noexcept;

  /// Gives a command of the control register. `enable_active` obeys the enable rule unless `force`;
  /// `start_synchronous` is refused as `listening` or `other_master` while the master may not send, unless
  /// `force`, which accepts another master that is there until it is gone.
  /// Leaving synchronous operation ends every open job as `master_stopped`.
  Refusal control(ControlCommand command, bool force = false) noexcept;

  // --- settings that may change while running; effective with the next interval

  /// Another mapping than the one in force ends what is released, and forgets what waits.
  Refusal set_reference_mapping(const ProcessMapping& mapping) noexcept;
  /// How this slave's actual value telegrams are read (M 4.16); it must be what the slave itself sends by.
  /// `slave_not_configured`, `mapping`: nothing is changed.
  Refusal set_actual_mapping(SlaveNumber slave, const ProcessMapping& mapping) noexcept;
  /// Which slave a reference telegram asks for actual values (M 4.19). `slave_not_configured`: nothing is
  /// changed.
  Refusal set_polling(Channel channel, const Cursor& cursor) noexcept;
  /// What reference value `value`, 0..7, may be. A release of values that are beyond minimum or maximum now
  /// ends.
  void set_reference_limits(std::uint8_t value, const ReferenceLimits& limits) noexcept;
  /// Automatic numbers, of polling and of the command channel, rise up to this slave and begin again at 0.
  void set_maximum_slave(SlaveNumber slave) noexcept;
  /// Which slaves each kind of job serves (M 4.6). `slave_not_configured`: a fixed slave is not, and all
  /// three stay.
  Refusal set_command_cursors(const Cursor& control_word, const Cursor& parameter,
                              const Cursor& transfer) noexcept;

  // --- what is known

  /// Value of `w_OPTION_STATUS`; waiting, set-up or active (M 3.2.2.3).
  State state() const noexcept;
  /// The interval that `begin_interval` or `pass_interval` named last; 0 before the first.
  IntervalNumber interval() const noexcept;
  /// The settings in force: those of the constructor with what was changed since.
  const MasterSettings& settings() const noexcept;
  /// Of the reference mapping in force: 1 at first, rises by one with each change.
  std::uint64_t mapping_number() const noexcept;
  /// What is known of a slave, also of one that is not configured; changes with the master's next call.
  const SlaveStatus& slave(SlaveNumber slave) const noexcept;
  /// The newest actual values of a slave; they stay when it is lost (`interval` tells their age).
  const ActualValues& actual(SlaveNumber slave) const noexcept;
  /// Whether the reference values of a telegram are released, and if not, why.
  const ReleaseStatus& release(Channel channel) const noexcept;
  /// Slaves as which two drives answer, until they are lost, released without force, or set-up begins.
  SlaveMask duplicate_slaves() const noexcept;
  /// Slaves that have answered since set-up began and are not configured; none without the census.
  SlaveMask unknown_slaves() const noexcept;
  /// Counters as of this call; the reference goes on changing, so whoever wants a difference copies it.
  const MasterCounters& counters() const noexcept;
  /// Another master has sent within the last 3 s.
  bool second_master() const noexcept;
  /// CAN identifier of the newest frame of another master; 0: there is none, or that was a SYNC.
  std::uint32_t second_master_identifier() const noexcept;
  /// Whether the master may send. In set-up, and in active operation that was told to stop, another master
  /// ends synchronous operation: cold restart.
  BusAccess access() const noexcept;
  /// In synchronous operation, but neither a SYNC edge nor a frame may be sent: give `pass_interval` instead
  /// of `begin_interval`.
  bool silent() const noexcept;
  /// Waiting and running ones of all slaves, 0..`CommandChannelSettings::parameter_queue`.
  std::size_t open_parameter_jobs() const noexcept;
  /// Waiting and running ones of all slaves, 0..`CommandChannelSettings::transfer_queue`.
  std::size_t open_transfers() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cansync
