#pragma once

#include <chrono>
#include <cstdint>
#include <span>
#include <vector>

#include "dds/daemon_identity.h"

namespace gateway::dds {

/// Decides which daemon a client's requests are for, by what it hears of those that serve its bus. Knows
/// neither DDS nor a clock: it is told who is matched, and whose status came.
///
/// - While one daemon alone is there, requests are for that one.
/// - When another appears, the one before may have died a moment ago, for DDS notices a death after seconds.
///   Nothing is asked until it has left or was silent for `kSilence`, or until it is heard again: then both
///   live.
/// - While two live, nothing is asked.
/// - Requests go to another start than the program knows of only after it was told.
///
/// Not thread safe.
class DaemonChoice {
 public:
  using Clock = std::chrono::steady_clock;
  /// Names the process of a daemon while it is matched; 0: none.
  using Place = std::uint64_t;

  /// A daemon tells its status at least once a second. One that has not for so long, while another has, is
  /// dead.
  static constexpr std::chrono::milliseconds kSilence{2500};
  /// Of the time between two looks so much counts at most: who was suspended has heard nobody.
  static constexpr std::chrono::milliseconds kLook{600};

  enum class View : std::uint8_t {
    none,     ///< no daemon is there, or none has told its identity
    one,      ///< requests are for `daemon()`
    unsure,   ///< another has appeared, and whether the one before lives is not known yet
    several,  ///< `living()` all serve the bus
  };

  /// A status of the daemon at `place` came.
  void heard(Place place, const DaemonIdentity& identity);

  /// To be called at least every `kLook`, after what was heard: those in `matched` are there at `now`.
  void look(Clock::time_point now, std::span<const Place> matched);

  /// As of the last `look`.
  View view() const noexcept { return view_; }
  /// Whom requests are for; when `view()` is not `one`, whom they were for last. All zero: nobody yet.
  const DaemonIdentity& daemon() const noexcept { return daemon_; }
  /// Those that may live, in the order in which they were first heard.
  std::vector<Place> living() const;
  /// May a reply to a request that was for this start still come?
  bool may_answer(const DaemonIdentity& start) const noexcept;

  /// The program was told why a request was not sent, or that the daemon it was for has gone.
  void program_told() noexcept;
  /// The program was told of this start.
  void program_told_of(const DaemonIdentity& start) noexcept;
  /// True while `view()` is `one`, but another start than that of which the program knows.
  bool to_be_told() const noexcept { return view_ == View::one && program_ != daemon_; }

 private:
  struct Known {
    Place place = 0;
    DaemonIdentity identity = {};
    std::uint64_t first = 0;  ///< in the order of everything that was heard
    std::uint64_t last = 0;
    std::chrono::nanoseconds when{0};  ///< it was heard last, in `watched_`
    bool fresh = true;                 ///< heard since the last look
    bool silent = false;               ///< dead, though it is matched
  };
  void find_silent();
  View look_at_living() const;
  void choose();

  std::vector<Known> known_;
  std::uint64_t heard_ = 0;
  std::chrono::nanoseconds watched_{0};  ///< time that counts
  Clock::time_point looked_;
  bool begun_ = false;

  View view_ = View::none;
  DaemonIdentity daemon_ = {};
  DaemonIdentity program_ = {};  ///< the start of which the program knows
  bool told_ = false;            ///< since `daemon_` was there alone: any other may follow
};

}  // namespace gateway::dds
