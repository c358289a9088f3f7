#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "cansync/observe/observation.h"

namespace cansync::observe {

/// An instant as interval and time after its SYNC edge.
struct Instant {
  bool known = false;  ///< an edge came before it
  IntervalNumber interval = 0;
  Duration after_edge{};
};

/// Counts intervals by the SYNC edges of a recording; without any by WRC1, which is then taken to stand where
/// our master would send it.
class LineClock {
 public:
  /// `sync_seen`: the recording has SYNC edges. `by_count`: its time stamps say nothing, so each edge begins the
  /// next interval.
  LineClock(BitRate bit_rate, bool sync_seen, bool by_count = false) noexcept;

  /// A SYNC edge.
  void sync(Duration at) noexcept;
  /// WRC1 began; does nothing when there are SYNC edges.
  void reference_one(Duration at) noexcept;
  /// Nothing is known until the next edge.
  void begin_anew() noexcept;
  /// `at` in intervals; edges that are missing are gone on from the last one.
  Instant instant(Duration at) const noexcept;

 private:
  void edge(Duration at) noexcept;

  const SlotTimes& times_;
  bool sync_seen_;
  bool by_count_;
  std::optional<Duration> edge_;
  IntervalNumber interval_ = 1;
};

/// How often telegrams began in each microsecond of the interval.
class SlotHistogram {
 public:
  /// A telegram began; over 8191 us counts as 8191.
  void add(Place place, Duration after_edge);
  /// What was added so far.
  SlotUse use(Place place) const noexcept;

 private:
  static constexpr std::size_t kMicroseconds = 8192;
  std::array<std::vector<std::uint32_t>, kPlaces> counts_;
  std::array<SlotUse, kPlaces> use_ = {};
};

}  // namespace cansync::observe
