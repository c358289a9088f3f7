#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "j1939/identifier.h"

namespace j1939 {

/// Parameter groups that are received, perhaps of one source alone.
struct PgnRange {
  Pgn first = 0;                  ///< 0..kLargestPgn
  Pgn last = kLargestPgn;         ///< at least `first`
  std::optional<Address> source;  ///< nothing: of everybody

  friend bool operator==(const PgnRange&, const PgnRange&) = default;
};

/// Ranges in their order: the first that takes a message counts. Realtime safe; one thread.
class PgnFilter {
 public:
  static constexpr std::size_t kMostRanges = 64;

  /// Appends a range; false when there is no room for it.
  bool add(const PgnRange& range) noexcept;
  /// Position of the first range that takes the group of this source, 0..kMostRanges-1; nothing: none.
  std::optional<std::uint8_t> match(Pgn number, Address source) const noexcept;

 private:
  std::array<PgnRange, kMostRanges> ranges_ = {};
  std::size_t size_ = 0;
};

}  // namespace j1939
