#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "can/bus.h"
#include "can/frame.h"
#include "cansync/slave/slave.h"
#include "daemon/cansync_slave/exchange.h"

namespace cansyncd {

/// The answers of a slave on their way to the bus: each goes out in its window, or not at all. One that has
/// to wait for its window holds up those of its own slot alone. Realtime thread only; realtime safe.
class AnswerQueue {
 public:
  /// An answer and when it was asked for.
  struct Answer {
    cansync::SlaveAnswer answer;
    can::Time edge{};   ///< that its window counts from
    can::Time asked{};  ///< last bit of the request
  };

  /// Takes an answer; without room it is left out.
  void add(const Answer& answer) noexcept;

  /// The slave leaves active operation: no actual values go out any more. `all`: it leaves synchronous
  /// operation, too, and nothing does: what waits here was dropped, and its asker is told so.
  void drop(bool all) noexcept;

  /// The next answer that may go out at `now`; `slave` counts those that are too late.
  std::optional<can::Frame> next(can::Time now, cansync::Slave& slave) noexcept;

  /// What became of it.
  void handed_over(can::SendResult result, can::Time now) noexcept;

  /// When the next answer may go out; Time::max() when there is none.
  can::Time next_deadline() const noexcept;
  /// An answer may go out at `now`.
  bool due(can::Time now) const noexcept { return next_deadline() <= now; }
  const AnswerCounters& counters() const noexcept { return counters_; }

 private:
  /// More requests than that cannot end within one slot.
  static constexpr unsigned kRoom = 4;

  can::Time begin(unsigned place) const noexcept {
    return answers_[place].edge + answers_[place].answer.window.earliest;
  }
  bool first_of_slot(unsigned place) const noexcept;
  void remove(unsigned place) noexcept;

  std::array<Answer, kRoom> answers_ = {};  ///< oldest first
  unsigned size_ = 0;
  unsigned handed_ = 0;  ///< place of the answer that `next` gave last
  AnswerCounters counters_;
};

}  // namespace cansyncd
