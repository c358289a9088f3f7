#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

namespace cansyncd {

/// A client's identity, as its requests carry it.
using ClientIdentity = std::array<std::uint8_t, 16>;

/// Number of a request that is open at the daemon; no two have the same.
using JobId = std::uint64_t;

/// One queue of whoever executes requests: all jobs of a kind for one number.
struct Lane {
  constexpr Lane() = default;
  /// `lane_kind`: an enumeration of the protocol's, from 0 without gaps; it says what `lane_number` is.
  template <class Kind>
  requires std::is_enum_v<Kind>
  constexpr Lane(Kind lane_kind, std::uint8_t lane_number) noexcept
      : kind(static_cast<std::uint8_t>(lane_kind)), number(lane_number) {}

  std::uint8_t kind = 0;
  std::uint8_t number = 0;  ///< e.g. a slave or a priority
  friend bool operator==(const Lane&, const Lane&) = default;
  friend bool operator<(const Lane& a, const Lane& b) {
    return std::tie(a.kind, a.number) < std::tie(b.kind, b.number);
  }
};

/// How many jobs of a kind may be given at a time.
struct LaneLimit {
  unsigned in_lane = 1;                                      ///< of one lane
  unsigned together = std::numeric_limits<unsigned>::max();  ///< of all lanes of the kind
  /// Weight of one lane and one client, over 0; who has none given there may give a heavier one.
  unsigned of_client = std::numeric_limits<unsigned>::max();
};

/// Whether a request has its turn.
struct LaneTurn {
  bool waits = false;  ///< it has not been given
  JobId behind = 0;    ///< it waits for this one, the oldest that was given in its lane; 0: none was
};

/// The limits of a protocol's kinds of lanes; index: kind.
using LaneLimits = std::vector<LaneLimit>;

/// Holds requests back until it is their turn, so that clients share every lane fairly.
///
/// In each lane the clients that have requests waiting take turns, one request each; those of one client keep
/// their order. With `in_lane` requests of a lane given and n other clients waiting in it, a client's first
/// request there is the (in_lane + n + 1)th to end at the latest, however many the others have. Lanes that
/// share the limit `together` take turns too. Whose next request would be over `of_client` keeps its turn until
/// others of its own have ended, and the other clients go on: where a request may stay long, or is much for the bus,
/// nobody waits for more than that of each. Not thread safe; allocates.
class FairLanes {
 public:
  /// A lane of a kind that has no limit must not be used.
  explicit FairLanes(LaneLimits limits) : limits_(std::move(limits)), together_(limits_.size()) {}

  /// Other limits, of the same kinds; what was given stays given.
  void set_limits(LaneLimits limits) { limits_ = std::move(limits); }

  /// Puts a request behind the others of its client in its lane. `id` must be new; `weight`, over 0: what it counts
  /// for its client, such as frames.
  void add(JobId id, const ClientIdentity& client, Lane lane, unsigned weight = 1);

  /// Forgets a request, whether it still waits or was given and has ended. An unknown one is ignored.
  void remove(JobId id);

  /// True while the request has not been given.
  bool waits(JobId id) const;

  /// The turn of each of these requests, in their order; of an unknown one that it does not wait.
  std::vector<LaneTurn> turns(std::span<const JobId> ids) const;

  /// Calls `give(id)` for every request whose turn it is, until limits are reached or `give` returns false
  /// (there is no room): that request keeps its turn. Returns false only then.
  template <class Give>
  bool hand_over(Give&& give) {
    while (const auto lane = next_lane()) {
      if (!give(first_of(*lane))) return false;
      given(*lane);
    }
    return true;
  }

 private:
  struct Queue {
    std::deque<ClientIdentity> turns;  ///< clients with waiting requests, the next in front
    std::map<ClientIdentity, std::deque<JobId>> waiting;
    std::map<ClientIdentity, unsigned> given_of;  ///< weight of clients that have some
    unsigned given = 0;
  };
  struct Where {
    Lane lane;
    ClientIdentity client = {};
    bool given = false;
    unsigned weight = 1;
  };

  std::optional<Lane> next_lane() const;
  /// The client of `turns` that gives next; its end: all have their share.
  std::deque<ClientIdentity>::const_iterator next_client(Lane lane, const Queue& queue) const;
  JobId first_of(Lane lane) const;
  void given(Lane lane);
  static void drop_waiting(Queue& queue, const ClientIdentity& client, JobId id);

  LaneLimits limits_;
  std::map<Lane, Queue> lanes_;
  std::map<JobId, Where> jobs_;
  std::vector<unsigned> together_;  ///< given, by kind
  std::optional<Lane> last_;        ///< lane that gave last
};

}  // namespace cansyncd
