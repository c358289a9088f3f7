#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "cansync/jobs.h"
#include "cansync/mapping.h"
#include "cansync/master.h"
#include "cansync/numbers.h"
#include "cansync/reference_release.h"
#include "cansync/release_status.h"
#include "cansync/settings.h"
#include "cansync/telegram.h"

namespace cansync {

/// Reference values out and actual values in: mapping, release, and which slave is asked
/// (M 3.1.1.1, 3.2.2.4, 3.2.2.5). Realtime safe; not thread safe.
class ProcessData {
 public:
  ProcessData(const MasterSettings& settings, MasterListener& listener) noexcept;

  /// Forgets reference values and what was asked; actual values stay.
  void stop() noexcept;

  /// A new interval: automatic cursors rise. Returns the slaves that were asked in the last interval and sent
  /// nothing.
  std::array<std::optional<SlaveNumber>, kChannels> begin_interval(IntervalNumber now) noexcept;

  Refusal update(const ReferenceUpdate& update) noexcept;
  void stop_release(Channel channel, std::uint32_t hold) noexcept;

  /// The channel's reference telegram for this interval; nothing when no values are released.
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

  Refusal set_reference_mapping(const ProcessMapping& mapping) noexcept;
  Refusal set_polling(Channel channel, const Cursor& cursor) noexcept;
  void set_maximum_slave(SlaveNumber slave) noexcept { settings_.maximum_slave = slave; }
  Refusal set_actual_mapping(SlaveNumber slave, const ProcessMapping& mapping) noexcept;

  const ProcessSettings& settings() const noexcept { return settings_; }
  /// Of the reference mapping in force.
  std::uint64_t mapping_number() const noexcept { return mapping_number_; }
  const ReleaseStatus& release(Channel channel) const noexcept {
    return output_[index(channel)].release.status();
  }
  const ProcessMapping& actual_mapping(SlaveNumber slave) const noexcept {
    return actual_mapping_[slave.value()];
  }
  const ActualValues& actual(SlaveNumber slave) const noexcept { return actual_[slave.value()]; }
  std::uint64_t not_released() const noexcept { return not_released_; }

 private:
  struct Output {
    ReferenceRelease release;
    std::uint8_t automatic = 0;  ///< the rising slave number
    std::optional<SlaveNumber> asked;
    bool on_bus = false;  ///< the telegram that asks was on the bus
  };

  std::uint8_t polled(const Output& output, Channel channel) const noexcept;

  ProcessSettings settings_;
  MasterListener& listener_;
  SlaveMask configured_;
  std::array<ProcessMapping, kSlaves> actual_mapping_;
  std::array<ActualValues, kSlaves> actual_ = {};
  Values references_ = {};
  std::array<Output, kChannels> output_;
  std::uint64_t mapping_number_ = 1;
  IntervalNumber now_ = 0;
  bool first_ = true;
  std::uint64_t not_released_ = 0;
};

}  // namespace cansync
