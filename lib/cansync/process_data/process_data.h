#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "cansync/channel/jobs.h"
#include "cansync/master.h"
#include "cansync/process_data/reference_check.h"
#include "cansync/process_data/reference_release.h"
#include "cansync/process_data/release_status.h"
#include "cansync/settings/settings.h"
#include "cansync/telegram/mapping.h"
#include "cansync/telegram/numbers.h"
#include "cansync/telegram/telegram.h"

namespace cansync {

/// The values that a mapping carries as words of 16 bits, of each telegram; worked out once and not with each
/// telegram.
using WordMasks = std::array<std::uint8_t, kChannels>;

/// Reference values out and actual values in: mapping, release, and which slave is asked
/// (M 3.1.1.1, 3.2.2.4, 3.2.2.5). Realtime safe; not thread safe.
class ProcessData : private ActualSource {
 public:
  /// `listener` must outlive this object; `settings`, which must have passed `check`, is copied.
  ProcessData(const MasterSettings& settings, MasterListener& listener) noexcept;

  /// Ends what is released, forgets what was given for later, and what was asked. Values keep their numbers.
  void stop() noexcept;

  /// A new interval: automatic cursors rise. Returns the slaves that were asked in the last interval and sent
  /// nothing.
  std::array<std::optional<SlaveNumber>, kChannels> begin_interval(IntervalNumber now) noexcept;

  /// Takes new reference values (M 4.19). Refusals: `mapping_changed`, `nothing_valid`, `release_too_long`,
  /// `value_too_wide`, `interval_passed`, `too_old`, and `queue_full` when too many wait; the release before
  /// goes on then, unless the update `takes_over`.
  Refusal update(const ReferenceUpdate& update) noexcept;
  /// Ends what is released, and forgets what was given for later.
  void bus_lost() noexcept;
  /// See `Master::stop_release`; `hold` in intervals, 0: at once.
  void stop_release(Channel channel, std::uint32_t hold) noexcept;

  /// The channel's reference telegram for this interval; nothing when no values are released. Updates that are
  /// due and beyond a limit are refused, and the listener is told.
  std::optional<ReferenceTelegram> telegram(Channel channel) noexcept;
  /// The telegram was handed to the bus: its slave is expected to answer.
  void sent(Channel channel) noexcept;
  /// The telegram was left out: its values are too old for the next interval, unless they are released for
  /// longer.
  void left_out(Channel channel) noexcept;

  /// The telegram was on the bus: from here on its answer may come.
  void transmitted(Channel channel) noexcept { output_[index(channel)].on_bus = true; }

  /// Takes an actual value telegram; false when nobody asked for it, or not yet.
  bool receive(const ActualTelegram& telegram) noexcept;

  /// The slave whose actual values of `channel` are waited for in this interval.
  std::optional<SlaveNumber> asked(Channel channel) const noexcept { return output_[index(channel)].asked; }

  /// Another mapping than the one in force ends what is released and forgets what waits (M 4.15). `mapping`:
  /// a word names a value of the other telegram, nothing is changed.
  Refusal set_reference_mapping(const ProcessMapping& mapping) noexcept;
  /// Which slave the telegram asks, from the next one on (M 4.19). `slave_not_configured`: nothing is
  /// changed.
  Refusal set_polling(Channel channel, const Cursor& cursor) noexcept;
  /// What reference value `value` may be, for the next one. A release of values that are beyond minimum or
  /// maximum now ends.
  void set_reference_limits(std::uint8_t value, const ReferenceLimits& limits) noexcept;
  /// Automatic numbers rise up to this slave and begin again at 0.
  void set_maximum_slave(SlaveNumber slave) noexcept { settings_.maximum_slave = slave; }
  /// How this slave's telegrams are read, from the next one on (M 4.16). `slave_not_configured`, `mapping`:
  /// nothing is changed.
  Refusal set_actual_mapping(SlaveNumber slave, const ProcessMapping& mapping) noexcept;

  /// The settings of the constructor, with mapping and polling in force.
  const ProcessSettings& settings() const noexcept { return settings_; }
  /// Of the reference mapping in force.
  std::uint64_t mapping_number() const noexcept { return mapping_number_; }
  /// Whether a telegram's values are released, and if not, why.
  const ReleaseStatus& release(Channel channel) const noexcept {
    return output_[index(channel)].release.status();
  }
  /// The mapping in force, by which the slave's next telegram is read.
  const ProcessMapping& actual_mapping(SlaveNumber slave) const noexcept {
    return actual_mapping_[slave.value()];
  }
  /// What the slave sent last; zeros before its first telegram (`count` tells).
  const ActualValues& actual(SlaveNumber slave) const noexcept { return actual_[slave.value()]; }
  /// Telegrams asked for while nothing was released, of both channels, since the start.
  std::uint64_t not_released() const noexcept { return not_released_; }

 private:
  struct Output {
    ReferenceRelease release;
    std::optional<SlaveNumber> asked;
    bool on_bus = false;    ///< the telegram that asks was on the bus
    bool released = false;  ///< the telegram of this interval carries values
  };

  std::uint8_t polled(Channel channel) const noexcept;
  void set_mapping(unsigned slave, const ProcessMapping& mapping) noexcept;
  /// No value of which the low word alone is sent would be cut.
  bool fits_words(const ReferenceUpdate& update) const noexcept;
  void take_due(Channel channel) noexcept;
  void refuse(Channel channel, const LimitViolation& beyond) noexcept;
  std::optional<ActualNumber> recent(SlaveNumber slave, std::uint8_t value) const noexcept override;

  ProcessSettings settings_;
  MasterListener& listener_;
  SlaveMask configured_;
  std::array<ProcessMapping, kSlaves> actual_mapping_;
  std::array<WordMasks, kSlaves> actual_words_ = {};                 ///< of these mappings
  std::array<std::array<Unpacking, kChannels>, kSlaves> actual_of_;  ///< of the telegrams, by these mappings
  std::array<CarriedValues, kChannels> carried_ = {};                ///< by the reference mapping
  std::array<ActualValues, kSlaves> actual_ = {};
  /// A telegram came since the mapping in force.
  std::array<std::array<bool, kChannels>, kSlaves> actual_by_mapping_ = {};
  Values references_ = {};
  ReferenceCheck check_;
  std::array<Output, kChannels> output_;
  std::uint64_t mapping_number_ = 1;
  IntervalNumber now_ = 0;
  std::uint8_t automatic_ = 0;  ///< the rising slave number
  bool first_ = true;
  std::uint64_t not_released_ = 0;
};

}  // namespace cansync
