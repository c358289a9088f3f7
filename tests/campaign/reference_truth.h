#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "cansync/jobs.h"
#include "cansync/telegram.h"

namespace cansyncd::campaign {

/// Which reference values may still be released. Each update carries its own number in both words of every
/// value, so that a telegram tells whose values it has.
class ReferenceTruth {
 public:
  ReferenceTruth() : updates_(kKnown) {}

  /// The values of the next update and its number.
  std::uint32_t next_number() noexcept { return ++last_; }
  static std::uint32_t value_of(std::uint32_t number) noexcept {
    return (number % kKnown) | ((number % kKnown) << 16);
  }

  /// An update with these values was pushed.
  void pushed(std::uint32_t number, const cansync::ReferenceUpdate& update);

  /// The writer of the channel has withdrawn its values.
  void withdrawn(cansync::Channel channel) noexcept { withdrawn_[index(channel)] = last_; }
  /// The realtime thread has taken everything that was pushed before this interval: a withdrawal holds now.
  void all_taken() noexcept { in_force_ = withdrawn_; }
  /// The master is not in active operation, and has taken everything: nothing given before may come again.
  void left_active() noexcept { in_force_ = withdrawn_ = {last_, last_}; }

  /// The master released this telegram in interval `now`. Notes when it must not.
  void released(const cansync::ReferenceTelegram& telegram, std::uint64_t now);

  /// What was wrong first; empty: nothing.
  const std::string& complaint() const noexcept { return complaint_; }

 private:
  static constexpr std::uint32_t kKnown = 4096;
  struct Update {
    std::uint32_t number = 0;
    cansync::Channel channel = cansync::Channel::one;
    std::uint64_t from = 0;
    std::uint32_t intervals = 0;
    std::uint32_t count = 0;
    std::uint64_t first = 0;  ///< interval of the first release
  };
  void complain(std::uint32_t number, const std::string& what) {
    if (complaint_.empty()) complaint_ = "reference values of update " + std::to_string(number) + " " + what;
  }

  std::vector<Update> updates_;  ///< the last ones, by number
  std::uint32_t last_ = 0;
  std::array<std::uint32_t, cansync::kChannels> withdrawn_ = {};  ///< no later update than this one
  std::array<std::uint32_t, cansync::kChannels> in_force_ = {};
  std::string complaint_;
};

}  // namespace cansyncd::campaign
