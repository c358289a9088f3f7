#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "can/frame.h"
#include "cansync/settings/mode.h"
#include "cansync/settings/timing.h"
#include "cansync/slave/answer_slot.h"
#include "cansync/slave/slave_application.h"
#include "cansync/slave/transfer_server.h"
#include "cansync/telegram/mapping.h"
#include "cansync/telegram/numbers.h"
#include "cansync/telegram/telegram.h"

namespace cansync {

/// Settings of one slave.
struct SlaveSideSettings {
  SlaveNumber number;
  BitRate bit_rate = BitRate::mbit1;
  ProcessMapping reference_mapping = {default_mapping(Channel::one), default_mapping(Channel::two)};
  ProcessMapping actual_mapping = {default_mapping(Channel::one), default_mapping(Channel::two)};
  bool full_length = true;            ///< RDC telegrams always have 8 bytes; false: as many as are mapped
  std::uint16_t block_limit = 300;    ///< longest block it takes, 1..4095 bytes
  std::uint8_t activate_command = 2;  ///< action "SYNC mode: activate" (unconfirmed)
  std::uint8_t activate_data = 1;     ///< its data byte (unconfirmed)
  /// Mapping by which this slave reads other slaves' actual values, if it listens to them.
  std::array<std::optional<ProcessMapping>, kSlaves> monitored = {};
};

/// What a slave has counted of one pair of reference and actual value telegrams since its start.
struct ActualCounters {
  std::uint64_t asked = 0;         ///< reference telegrams that named this slave
  std::uint64_t not_released = 0;  ///< of those: nothing was released, so there was no answer
  std::uint64_t released = 0;      ///< releases of the application
  std::uint64_t not_asked = 0;     ///< of those: withdrawn, replaced, or the interval ended, before
  std::uint64_t late = 0;          ///< answers left out because they would have started after their slot
  std::uint64_t sent = 0;          ///< answers that were on the bus
  std::uint64_t lost = 0;          ///< answers handed over and not on the bus by the next edge but one
};

/// What a slave has counted of its answers to commands since its start.
struct ResponseCounters {
  std::uint64_t asked = 0;  ///< commands that were answered, busy or not
  std::uint64_t busy = 0;   ///< of those: with busy
  std::uint64_t late = 0;   ///< left out because they would have started after their slot
  std::uint64_t sent = 0;   ///< were on the bus
};

/// What has become of the actual values of a telegram (M 3.2.3.5, control register).
enum class ActualRelease : std::uint8_t {
  none,      ///< nothing was released in this interval
  released,  ///< 0x05: waits for the master to ask
  built,     ///< 0x04: the telegram is built, and was not seen on the bus yet
  sent,      ///< it was on the bus
  late,      ///< it was left out: too late for its slot
};

/// The slave's side of CANsync, sans-IO (M 3.2.3): the full counterpart of `Master`.
///
/// `on_sync` at each edge, `receive` for every frame on the bus. A returned answer is handed to the bus when
/// its window begins, if `may_start` then says so; `sent` is told when it was on the bus. Before synchronous
/// operation nothing is heard; setting up, action commands, parameters and transfers are served; active,
/// process data too.
/// A command that replaces one answered busy drops the latter, unanswered. A transfer telegram that was
/// answered well and comes again (its answer was lost) gets the same answer, and the application is not
/// asked, as long as its block is open; so does a write whose answer was never on the bus: nothing is written twice. Nothing allocates,
/// blocks or throws; not thread safe.
class Slave {
 public:
  /// `application` must outlive the slave.
  Slave(const SlaveSideSettings& settings, SlaveApplication& application) noexcept;

  /// A SYNC edge arrived, `passed` intervals after the one before, at least 1: reference values count as old,
  /// actual values as not released, from here on.
  void on_sync(IntervalNumber passed = 1) noexcept;

  /// Intervals since the start, by `on_sync`.
  IntervalNumber interval() const noexcept { return interval_; }

  /// A frame was on the bus until `since_sync` (after the running interval's edge), or, for who takes time to
  /// answer, can be answered then: an answer that is not ready by the end of its slot gets the next one.
  /// Returns what this slave answers, if anything. What is no CANsync telegram is ignored.
  std::optional<SlaveAnswer> receive(const can::Frame& frame, Duration since_sync) noexcept;

  /// The same for a frame that is already decoded.
  std::optional<SlaveAnswer> receive(const Telegram& telegram, Duration since_sync) noexcept;

  /// Asked when an answer is about to be handed to the bus, so that it can start at `since_sync` of the
  /// interval in which it was asked for. False: after its window; it is left out, and counted.
  bool may_start(const SlaveAnswer& answer, Duration since_sync) noexcept;

  /// An answer of this slave was on the bus whole; another frame is ignored.
  void sent(const can::Frame& answer) noexcept;

  /// Releases actual values for the telegram of `channel` in this interval (control register 0x05,
  /// M 3.2.3.5): `values` 0..3 for channel one, 4..7 for channel two. One release is good for one telegram. A
  /// reference telegram that asks for actual values that are not released gets no answer.
  void release_actual(Channel channel, const Values& values) noexcept;
  /// What was released for this interval, and not asked for yet, is not sent.
  void withdraw_actual(Channel channel) noexcept;
  /// What has become of the release of this interval.
  ActualRelease release(Channel channel) const noexcept { return release_[index(channel)]; }

  /// Reference values, as the mapping filled them; `reference_fresh` tells if that telegram came, with at
  /// least one word, since the last edge.
  const Values& references() const noexcept { return references_; }
  /// True when that telegram came, with at least one word, since the last edge.
  bool reference_fresh(Channel channel) const noexcept { return fresh_[index(channel)]; }

  /// Values taken from another slave's actual value telegrams; zeros before the first.
  const Values& monitored(SlaveNumber slave) const noexcept { return monitored_[slave.value()]; }
  /// Those telegrams of one channel so far; goes on from 2^32 - 1 with 0.
  std::uint32_t monitored_count(SlaveNumber slave, Channel channel) const noexcept {
    return monitored_count_[slave.value()][index(channel)];
  }
  /// The interval in which that telegram came last; means nothing before the first.
  IntervalNumber monitored_interval(SlaveNumber slave, Channel channel) const noexcept {
    return monitored_interval_[slave.value()][index(channel)];
  }
  /// The monitored slave whose telegram of the channel came since the last edge (M 4.22: -128 is nothing).
  std::optional<SlaveNumber> heard(Channel channel) const noexcept { return heard_[index(channel)]; }

  /// Counters as of this call; they go on changing.
  const ActualCounters& counters(Channel channel) const noexcept { return counters_[index(channel)]; }
  /// Counters as of this call; they go on changing.
  const ResponseCounters& response_counters() const noexcept { return responses_; }

  /// Other mappings, from the next telegram on (M 3.2.3.4: also during active operation).
  void set_reference_mapping(const ProcessMapping& mapping) noexcept {
    settings_.reference_mapping = mapping;
    references_of_ = {Unpacking(mapping[0]), Unpacking(mapping[1])};
  }
  /// How this slave's own values are sent, from the next telegram on (M 3.2.3.4).
  void set_actual_mapping(const ProcessMapping& mapping) noexcept { settings_.actual_mapping = mapping; }
  /// How another slave's actual values are listened to; nothing: not any more.
  void set_monitored(SlaveNumber other, const std::optional<ProcessMapping>& mapping) noexcept {
    settings_.monitored[other.value()] = mapping;
  }

  /// The data byte of the newest action "SYNC mode", whatever it says (b_SYNC_MODUS); nothing before the
  /// first since synchronous operation began.
  std::optional<std::uint8_t> sync_mode() const noexcept { return sync_mode_; }

  /// True after the action "SYNC mode: activate".
  bool sync_activated() const noexcept { return sync_activated_; }

  /// Gives a command of the slave's control register; false: not allowed in this state. Leaving synchronous
  /// operation drops open blocks and pending parameter accesses and forgets the activation.
  bool control(ControlCommand command) noexcept;
  /// Value of `w_OPTION_STATUS` (M 3.2.2.3).
  State state() const noexcept { return state_; }

  /// The settings of the constructor, with the mappings in force.
  const SlaveSideSettings& settings() const noexcept { return settings_; }

  /// True while an upload or download block is open.
  bool transfer_open() const noexcept { return transfers_.open(); }

 private:
  enum class Answered : std::uint8_t { none, parameter, transfer };

  std::optional<can::Frame> answer(const Telegram& telegram) noexcept;
  std::optional<can::Frame> answer(const ReferenceTelegram& telegram) noexcept;
  std::optional<can::Frame> answer(const ParameterCommand& command) noexcept;
  void forget_interval() noexcept;
  void note_answer(bool busy, Answered kind) noexcept;
  /// Answers a transfer telegram.
  template <class Command>
  std::optional<can::Frame> serve_transfer(const Command& command) noexcept;
  void take(const ActionCommand& action) noexcept;
  void take(const ActualTelegram& telegram) noexcept;

  /// What was handed over and was not on the bus yet.
  struct Handed {
    can::Frame frame;
    IntervalNumber interval = 0;
  };

  // What every interval touches comes first, to lie together.
  State state_ = State::start_up;
  bool sync_activated_ = false;
  std::array<bool, kChannels> fresh_ = {};
  std::array<ActualRelease, kChannels> release_ = {};
  bool process_data_ = false;      ///< a reference telegram was on the bus since the last edge
  bool had_process_data_ = false;  ///< likewise in the interval before
  std::array<std::optional<SlaveNumber>, kChannels> heard_ = {};
  /// Whose the newest answer to a command is, until it was on the bus.
  Answered answered_kind_ = Answered::none;
  std::optional<std::uint8_t> sync_mode_;
  IntervalNumber interval_ = 0;
  Values references_ = {};
  Values actual_ = {};
  std::array<Unpacking, kChannels> references_of_;  ///< of the telegrams, by the mapping
  std::array<ActualCounters, kChannels> counters_ = {};
  std::array<std::optional<Handed>, kAnswerSlots> handed_ = {};  ///< of each slot
  SlaveSideSettings settings_;
  SlaveApplication& application_;
  std::optional<ParameterCommand> pending_;  ///< answered busy
  TransferServer transfers_;
  ResponseCounters responses_;
  std::optional<ParameterCommand> written_;  ///< a write whose answer was not on the bus yet
  can::Frame written_answer_;                ///< that answer
  std::array<Values, kSlaves> monitored_ = {};
  std::array<std::array<std::uint32_t, kChannels>, kSlaves> monitored_count_ = {};
  std::array<std::array<IntervalNumber, kChannels>, kSlaves> monitored_interval_ = {};
};

}  // namespace cansync
