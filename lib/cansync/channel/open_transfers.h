#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "cansync/telegram/numbers.h"

namespace cansync {

/// Which slaves may still have a transfer open that nobody here knows of: left by a master that was killed or
/// lost its power, or begun before the slave was away. Such a slave gets the cancel telegram (M 3.2.2.6,
/// "Cancellation of a job") once it answers, before any transfer. Needs no memory over a restart. Realtime
/// safe.
class OpenTransfers {
 public:
  /// Times the telegram is sent when it is not answered: some slaves may not answer it while nothing is open.
  static constexpr std::uint8_t kAttempts = 2;

  /// Nothing is known of these slaves.
  void forget(SlaveMask slaves) noexcept {
    unknown_.bits |= slaves.bits;
    for (const SlaveNumber slave : slaves) attempts_[slave.value()] = 0;
  }
  /// The slave has nothing open, or its transfer is one of ours.
  void known(SlaveNumber slave) noexcept {
    unknown_.set(slave, false);
    attempts_[slave.value()] = 0;
  }

  /// The slaves that still get the cancel telegram.
  SlaveMask unknown() const noexcept { return unknown_; }

  /// The cancel telegram was not answered.
  void unanswered(SlaveNumber slave) noexcept {
    if (++attempts_[slave.value()] >= kAttempts) known(slave);
  }

 private:
  SlaveMask unknown_;
  std::array<std::uint8_t, kSlaves> attempts_ = {};
};

}  // namespace cansync
