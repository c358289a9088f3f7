#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <optional>

#include "cansync/settings/timing.h"
#include "cansync/sim/drive.h"
#include "cansync/telegram/telegram.h"

namespace sim {

inline constexpr std::uint8_t kRigNumber = 3;

inline DriveSettings rig_settings() {
  DriveSettings settings;
  settings.slave.number = *cansync::SlaveNumber::from(kRigNumber);
  settings.memory.size = 4096;
  return settings;
}

/// One drive and a hand-driven bus: SYNC edges and telegrams at given times, answers as they come.
class DriveRig {
 public:
  explicit DriveRig(const DriveSettings& settings = rig_settings())
      : drive(settings), times(slot_times(settings.slave.bit_rate)) {}

  /// The next SYNC edge; `skip` edges stay away before it.
  void edge(unsigned skip = 0) {
    now += times.interval * (skip + 1);
    drive.on_sync(now);
  }

  /// `n` edges without a reference value.
  void edges(unsigned n) {
    for (unsigned i = 0; i < n; ++i) edge();
  }

  /// A telegram whose last bit was on the bus at `since_sync`.
  std::optional<Transmission> send(const cansync::Telegram& telegram,
                                   cansync::Duration since_sync = std::chrono::microseconds(100)) {
    return drive.on_frame(encode(telegram), now + since_sync);
  }

  /// Both words of reference values 0 and 1 (channel one) or 4 and 5 (channel two), asking slave `polled`.
  std::optional<Transmission> reference(std::int32_t first, std::int32_t second = 0,
                                        cansync::Channel channel = cansync::Channel::one,
                                        std::uint8_t polled = cansync::kPollNobody) {
    cansync::ReferenceTelegram telegram;
    telegram.channel = channel;
    telegram.polled = polled;
    const auto low = [](std::int32_t v) { return static_cast<std::uint16_t>(v & 0xFFFF); };
    const auto high = [](std::int32_t v) {
      return static_cast<std::uint16_t>(static_cast<std::uint32_t>(v) >> 16);
    };
    telegram.word = {low(first), high(first), low(second), high(second)};
    return send(telegram);
  }

  cansync::ParameterCommand read(std::uint16_t number) const {
    cansync::ParameterCommand command;
    command.slave = drive.number();
    command.number = *cansync::ParameterNumber::from(number);
    return command;
  }

  void activate() { send(action(2, 1, 0)); }
  void control(std::uint16_t word) { send(action(1, 0, word)); }
  static cansync::ActionCommand action(std::uint8_t command, std::uint8_t byte, std::uint16_t word) {
    return {cansync::SlaveMask::all(), command, byte, word};
  }

  /// Activates and lets edges come until the drive is locked.
  void lock() {
    edge();
    activate();
    for (unsigned i = 0; i < 5000 && !synchronized(); ++i) edge();
    ASSERT_TRUE(synchronized());
  }

  /// One interval in which the position reference comes.
  void follow(std::int32_t position) {
    reference(position);
    edge();
  }

  bool synchronized() const { return has(status_bit::synchronized); }
  bool has(std::uint16_t bit) const { return (drive.status_word() & bit) != 0; }
  std::int32_t actual(unsigned number) const { return static_cast<std::int32_t>(drive.actual()[number]); }
  std::int32_t position() const { return actual(0); }
  std::int32_t speed() const { return actual(1); }

  Drive drive;
  const cansync::SlotTimes& times;
  can::Time now = std::chrono::seconds(1);
};

}  // namespace sim
