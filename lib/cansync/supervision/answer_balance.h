#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "cansync/telegram/numbers.h"

namespace cansync {

/// Weighs the answers of each slave against the questions to it. One drive answers a question once, late or
/// never; two drives of one number answer it twice. Realtime safe; not thread safe.
class AnswerBalance {
 public:
  /// A command, or a reference telegram that asks for actual values, went to this slave in interval `now`.
  /// `place`: the actual value channels by their index, then the command channel. `away`: it has left many in a
  /// row without an answer; only the last of them may still be answered, and two drives that come do not hide
  /// behind the others.
  void asked(unsigned place, SlaveNumber slave, IntervalNumber now, bool away) noexcept {
    Count& count = at(place, slave, now);
    if (count.open && now - count.asked <= kLatest) {
      ++count.owed;
      count.newest_owed = count.asked;
    }
    count.owed = std::min(count.owed, away ? std::uint8_t{1} : kMostOwed);
    count.open = true;
    count.asked = now;
  }

  /// An answer of this slave came, wanted or not. `fits`: it would answer the question that was asked last.
  /// False: that question has its answer already, and none before it is without one.
  bool answered(unsigned place, SlaveNumber slave, IntervalNumber now, bool fits) noexcept {
    Count& count = at(place, slave, now);
    if (fits && count.open) {
      count.open = false;
      return true;
    }
    if (count.owed == 0) return !fits;
    --count.owed;
    return true;
  }

  /// Forgets all questions.
  void begin() noexcept { counts_ = {}; }

 private:
  /// A slow drive owes two or three answers at a time. More would hide for long that a second drive answers.
  static constexpr std::uint8_t kMostOwed = 4;
  /// What was not answered for so many intervals was lost: it hides no second drive.
  static constexpr IntervalNumber kLatest = 10;
  static constexpr unsigned kPlaces = kChannels + 1;

  struct Count {
    bool open = false;               ///< the last question has no answer yet
    std::uint8_t owed = 0;           ///< questions before it that have none, which may still come
    IntervalNumber asked = 0;        ///< the last question
    IntervalNumber newest_owed = 0;  ///< the last of those that `owed` counts
  };

  Count& at(unsigned place, SlaveNumber slave, IntervalNumber now) noexcept {
    Count& count = counts_[place][slave.value()];
    if (now - count.newest_owed > kLatest) count.owed = 0;
    return count;
  }

  std::array<std::array<Count, kSlaves>, kPlaces> counts_ = {};
};

}  // namespace cansync
