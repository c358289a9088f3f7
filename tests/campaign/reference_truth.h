#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "can/bus.h"
#include "cansync/channel/jobs.h"
#include "cansync/settings/reference_limits.h"
#include "cansync/telegram/telegram.h"

namespace cansyncd::campaign {

/// Who gives an update.
struct ReferenceOrigin {
  unsigned program = 0;
  bool of_daemon_before = false;
  std::optional<can::Time> written = {};  ///< nothing: its age is not looked at
};

/// Which reference values may still be released. Each update carries its own number in both words of every
/// value, so that a telegram tells whose values it has.
class ReferenceTruth {
 public:
  static constexpr unsigned kPrograms = 8;

  ReferenceTruth() : updates_(kKnown) {}

  /// The values of the next update and its number.
  std::uint32_t next_number() noexcept { return ++last_; }
  static std::uint32_t value_of(std::uint32_t number) noexcept {
    return (number % kKnown) | ((number % kKnown) << 16);
  }

  /// An update with these values was pushed.
  void pushed(std::uint32_t number, const cansync::ReferenceUpdate& update,
              const ReferenceOrigin& origin = {});

  /// The values of a writer that was lost go on for so many intervals more.
  void set_hold(std::uint32_t intervals) noexcept { hold_ = intervals; }
  /// No release begins with values older than this; 0: not looked at.
  void set_maximum_age(can::Time age) noexcept { maximum_age_ = age; }

  /// The program has given the telegram up, and the gateway was told: nothing it gave before may come, once
  /// what the gateway hands on was taken.
  void gave_up(cansync::Channel channel, unsigned program) noexcept {
    ended_[index(channel)][program] = last_;
  }
  /// A sample of the program came through: nothing that others gave before may come any more.
  void taken_over(cansync::Channel channel, unsigned program) noexcept {
    if (follows_lost_[index(channel)] == program) return;
    follows_lost_[index(channel)].reset();
    for (unsigned other = 0; other < kPrograms; ++other) {
      if (other != program) ended_[index(channel)][other] = last_;
    }
  }
  /// Likewise, behind a writer that was lost: the hold of its values goes on until some of the program can be
  /// released.
  void follows_lost(cansync::Channel channel, unsigned program) noexcept {
    follows_lost_[index(channel)] = program;
  }
  /// The gateway had room for every stop it wanted.
  void stops_handed_on() noexcept { ended_handed_on_ = ended_; }

  /// The writer of the channel has withdrawn its values.
  void withdrawn(cansync::Channel channel) noexcept { withdrawn_[index(channel)] = last_; }
  /// The realtime thread has taken everything that was pushed before this interval: a withdrawal holds now.
  void all_taken() noexcept {
    in_force_ = withdrawn_;
    ended_in_force_ = ended_handed_on_;
    if (std::exchange(mode_asked_, false)) sent_ = {};
  }
  /// Limits of the first value of each telegram, which has 32 bits and a sign.
  void set_limits(const cansync::AllReferenceLimits& limits) noexcept { limits_ = limits; }
  /// A mode was asked for: active operation may begin again at any time from now on.
  void mode_asked() noexcept { mode_asked_ = true; }

  /// The master is not in active operation, and has taken everything: nothing given before may come again.
  void left_active() noexcept { in_force_ = withdrawn_ = {last_, last_}; }

  /// The master released this telegram in interval `now`, at `at`. Notes when it must not.
  void released(const cansync::ReferenceTelegram& telegram, std::uint64_t now, can::Time at);

  /// A telegram came to another writer than the rule says.
  void complain_of_owner(const std::string& what) {
    if (owner_complaint_.empty()) owner_complaint_ = "a telegram " + what;
  }

  /// What was wrong first with who had a telegram; empty: nothing.
  const std::string& owner_complaint() const noexcept { return owner_complaint_; }
  /// What was wrong first with how often values are released; empty: nothing.
  const std::string& complaint() const noexcept { return complaint_; }
  /// Likewise with who gave them.
  const std::string& giver_complaint() const noexcept { return giver_complaint_; }
  /// Likewise with their limits.
  const std::string& limit_complaint() const noexcept { return limit_complaint_; }
  /// Likewise with their age.
  const std::string& age_complaint() const noexcept { return age_complaint_; }

 private:
  static constexpr std::uint32_t kKnown = 4096;
  struct Update {
    std::uint32_t number = 0;
    cansync::Channel channel = cansync::Channel::one;
    std::uint64_t from = 0;
    std::uint32_t intervals = 0;
    std::uint32_t count = 0;
    std::uint64_t first = 0;  ///< interval of the first release
    ReferenceOrigin origin = {};
  };
  using Ended = std::array<std::array<std::uint32_t, kPrograms>, cansync::kChannels>;

  static void note(std::string& complaint, std::uint32_t number, const std::string& what) {
    if (complaint.empty()) complaint = "reference values of update " + std::to_string(number) + " " + what;
  }
  void complain(std::uint32_t number, const std::string& what) { note(complaint_, number, what); }
  void look_at_limits(const cansync::ReferenceTelegram& telegram);
  void look_at_giver(const Update& update);
  void look_at_age(const Update& update, std::uint64_t now, can::Time at);

  std::vector<Update> updates_;  ///< the last ones, by number
  std::uint32_t last_ = 0;
  std::array<std::uint32_t, cansync::kChannels> withdrawn_ = {};  ///< no later update than this one
  std::array<std::uint32_t, cansync::kChannels> in_force_ = {};
  Ended ended_ = {};            ///< by channel and program: no later update than this one
  Ended ended_handed_on_ = {};  ///< as far as the gateway has said so
  Ended ended_in_force_ = {};   ///< as far as the realtime thread has taken it
  std::array<std::optional<unsigned>, cansync::kChannels> follows_lost_ = {};
  can::Time maximum_age_{0};
  std::uint32_t hold_ = 0;
  std::string complaint_;
  std::string giver_complaint_;
  std::string limit_complaint_;
  std::string owner_complaint_;
  cansync::AllReferenceLimits limits_ = {};
  bool mode_asked_ = false;
  std::array<std::optional<std::int64_t>, cansync::kChannels> sent_ = {};  ///< first value of each telegram
  std::string age_complaint_;
};

}  // namespace cansyncd::campaign
