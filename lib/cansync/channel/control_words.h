#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "cansync/channel/jobs.h"
#include "cansync/telegram/numbers.h"

namespace cansync {

/// The control words that wait to be sent: one of each slave, the newest, as in the registers of the manuals
/// (M 3.2.2.6). Plain values; realtime safe; not thread safe.
class ControlWords {
 public:
  /// A control word that waits: its request, and when it may go.
  struct Word {
    ControlWordRequest request;
    IntervalNumber last = 0;  ///< interval in which it may be sent last
    bool passes = false;      ///< waits for no cursor: it stops its slave, or is the failsafe reaction's
    std::uint64_t turn = 0;   ///< among words that pass the lowest goes first; `put` gives it
  };

  /// The slaves for which a word waits.
  SlaveMask waiting() const noexcept { return waiting_; }
  /// The slaves whose word waits for no cursor.
  SlaveMask passing() const noexcept { return passing_; }
  /// The slaves whose word is the failsafe reaction's.
  SlaveMask failsafe() const noexcept { return failsafe_; }
  /// Only for a slave of `waiting`.
  const Word& of(SlaveNumber slave) const noexcept { return words_[slave.value()]; }

  /// The slave of the word that has waited longest of those that wait for no cursor; nothing: none does.
  std::optional<SlaveNumber> oldest_passing() const noexcept {
    std::optional<SlaveNumber> oldest;
    for (const SlaveNumber slave : passing_) {
      if (!oldest || of(slave).turn < of(*oldest).turn) oldest = slave;
    }
    return oldest;
  }

  /// Puts a word in the place of the one that waits for its slave, if one does. A word that passes keeps the
  /// turn of the one that passed before it: else a slave's words, given without end, would never be the
  /// oldest.
  void put(const Word& word) noexcept {
    const SlaveNumber slave = word.request.slave;
    const std::uint64_t turn = passing_.has(slave) ? of(slave).turn : ++turns_;
    words_[slave.value()] = word;
    words_[slave.value()].turn = turn;
    waiting_.set(slave);
    passing_.set(slave, word.passes);
    failsafe_.set(slave, word.request.failsafe);
  }

  /// Takes a slave's word out and returns whose it was. Only for a slave of `waiting`.
  JobId remove(SlaveNumber slave) noexcept {
    for (SlaveMask* mask : {&waiting_, &passing_, &failsafe_}) mask->set(slave, false);
    return words_[slave.value()].request.id;
  }

  /// Takes out every word for which `match` holds and calls `gone` with its job.
  template <class Match, class Gone>
  void remove_if(Match match, Gone gone) noexcept {
    for (const SlaveNumber slave : waiting_) {
      if (match(of(slave))) gone(remove(slave));
    }
  }

 private:
  std::array<Word, kSlaves> words_ = {};
  std::uint64_t turns_ = 0;  ///< given so far
  SlaveMask waiting_;
  SlaveMask passing_;
  SlaveMask failsafe_;
};

}  // namespace cansync
