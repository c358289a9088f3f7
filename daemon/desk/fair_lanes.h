#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <tuple>

#include "cansync/jobs.h"
#include "cansync/settings.h"

namespace cansyncd {

/// A client's identity, as its requests carry it.
using ClientIdentity = std::array<std::uint8_t, 16>;

/// What a request competes for.
enum class LaneKind : std::uint8_t { parameter, transfer, control_word, broadcast, line };
inline constexpr unsigned kLaneKinds = 5;

/// One queue of the master: all jobs of a kind for one slave (broadcast: of one priority; line: the one lane
/// of everything that takes effect at once).
struct Lane {
  LaneKind kind = LaneKind::line;
  std::uint8_t number = 0;  ///< slave or priority
  friend bool operator==(const Lane&, const Lane&) = default;
  friend bool operator<(const Lane& a, const Lane& b) {
    return std::tie(a.kind, a.number) < std::tie(b.kind, b.number);
  }
};

/// How many jobs of a kind the master may have at a time.
struct LaneLimits {
  std::array<unsigned, kLaneKinds> in_lane = {};   ///< of one lane
  std::array<unsigned, kLaneKinds> together = {};  ///< of all lanes of the kind
};

/// The limits that keep every queue of the master from filling up: few jobs of a lane, so that nobody waits
/// behind many of another client, but enough that the slave need not wait for this thread.
LaneLimits lane_limits(const cansync::CommandChannelSettings& settings) noexcept;

/// Holds requests back until it is their turn, so that clients share every lane fairly.
///
/// In each lane the clients that have requests waiting take turns, one request each; those of one client keep
/// their order. With `in_lane` requests of a lane given and n other clients waiting in it, a client's first
/// request there is the (in_lane + n + 1)th to end at the latest, however many the others have. Lanes that
/// share the limit `together` take turns too. Not thread safe; allocates.
class FairLanes {
 public:
  explicit FairLanes(const LaneLimits& limits) noexcept : limits_(limits) {}

  /// Puts a request behind the others of its client in its lane. `id` must be new.
  void add(cansync::JobId id, const ClientIdentity& client, Lane lane);

  /// Forgets a request, whether it still waits or was given and has ended. An unknown one is ignored.
  void remove(cansync::JobId id);

  /// True while the request has not been given.
  bool waits(cansync::JobId id) const;

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
    std::map<ClientIdentity, std::deque<cansync::JobId>> waiting;
    unsigned given = 0;
  };
  struct Where {
    Lane lane;
    ClientIdentity client = {};
    bool given = false;
  };

  std::optional<Lane> next_lane() const;
  cansync::JobId first_of(Lane lane) const;
  void given(Lane lane);
  static void drop_waiting(Queue& queue, const ClientIdentity& client, cansync::JobId id);

  LaneLimits limits_;
  std::map<Lane, Queue> lanes_;
  std::map<cansync::JobId, Where> jobs_;
  std::array<unsigned, kLaneKinds> together_ = {};
  Lane last_;  ///< lane that gave last
};

}  // namespace cansyncd
