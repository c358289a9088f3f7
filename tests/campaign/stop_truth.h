#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "cansync/channel/jobs.h"
#include "cansync/telegram/telegram.h"

namespace cansyncd::campaign {

/// Control words that stop: each is on the bus in the next interval but one after its request, whatever else
/// waits, or has its answer by then. With others that were given before it, it is twice as many intervals as
/// there are words; those given after it cost it nothing. An interval in which no command could go out does
/// not count.
class StopTruth {
 public:
  /// The word was pushed; `room`: few enough requests were before it to be taken in the next interval.
  void pushed(cansync::JobId id, cansync::SlaveNumber slave, std::uint16_t word, bool room) {
    const std::size_t before = waiting_.size();
    waiting_.push_back({id, slave, word, room});
    waiting_.back().before = before;
  }
  /// The realtime thread has taken everything that was pushed before this interval.
  void all_taken() noexcept {
    for (Waiting& each : waiting_) each.taken = true;
  }
  /// A control word or broadcast was handed to the bus.
  void handed_over(const cansync::ActionCommand& action) {
    for (Waiting& each : waiting_) {
      if (action.command == 1 && action.data_word == each.word && action.slaves.has(each.slave))
        each.on_bus = true;
    }
  }
  void answered(cansync::JobId id) {
    std::erase_if(waiting_, [id](const Waiting& each) { return each.id == id; });
  }
  /// An interval has ended. `free`: a command could go out in it, and the answers of it were read.
  void interval_ended(bool free) {
    for (Waiting& each : waiting_) {
      if (each.on_bus) continue;
      if (free && (each.taken || each.room)) ++each.intervals;
      if (each.intervals < 2 * (each.before + 1) || !complaint_.empty()) continue;
      complaint_ =
          "the control word of request " + std::to_string(each.id) + " to slave " +
          std::to_string(each.slave.value()) + " stops it, and is neither on the bus nor answered after " +
          std::to_string(each.intervals) + " intervals behind " + std::to_string(each.before) + " others";
    }
  }

  /// What was wrong first; empty: nothing.
  const std::string& complaint() const noexcept { return complaint_; }

 private:
  struct Waiting {
    cansync::JobId id = 0;
    cansync::SlaveNumber slave;
    std::uint16_t word = 0;
    bool room = false;
    bool taken = false;
    bool on_bus = false;        ///< or an equal word of another request was: which one, nobody can tell
    std::size_t before = 0;     ///< words without a read answer when it was given
    std::size_t intervals = 0;  ///< in which it could have gone out
  };

  std::vector<Waiting> waiting_;
  std::string complaint_;
};

}  // namespace cansyncd::campaign
