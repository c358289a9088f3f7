#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "can/frame.h"

namespace layer2 {

/// Which kinds of frames a range takes.
enum class FrameKinds : std::uint8_t { data, remote, data_and_remote };

/// Identifiers `first` to `last`, both included, of one width.
struct ReceiveRange {
  std::uint32_t first = 0;  ///< 0..0x7FF; extended 0..0x1FFFFFFF
  std::uint32_t last = 0;   ///< `first`..0x7FF; extended `first`..0x1FFFFFFF
  bool extended = false;    ///< 29-bit identifiers; false: 11-bit ones
  FrameKinds kinds = FrameKinds::data_and_remote;
  bool high_priority = false;  ///< what it takes overtakes what waits to be fetched (Helmholz 6.3.3)
  friend bool operator==(const ReceiveRange&, const ReceiveRange&) = default;
};

/// What can be wrong with a range.
enum class RangeProblem : std::uint8_t {
  none,
  identifier_too_large,  ///< `first` or `last` has more bits than the width allows
  reversed,              ///< `first` is greater than `last`
};

/// Looks at a range alone; pure and realtime safe.
RangeProblem check(const ReceiveRange& range) noexcept;

/// True when the range takes the frame; never for error frames. Pure and realtime safe.
bool takes(const ReceiveRange& range, const can::Frame& frame) noexcept;

/// The node filter (Helmholz 6.3.4, "bit filter"): a frame whose identifier has the node's number in its
/// lower seven bits, or 0, data or remote. Of 29-bit identifiers, when `extended`, the lower seven bits count
/// too.
struct NodeFilter {
  std::uint8_t node = 1;  ///< 1..127
  bool extended = false;  ///< 29-bit identifiers; false: 11-bit ones
};

/// Pure and realtime safe; never an error frame.
bool takes(const NodeFilter& filter, const can::Frame& frame) noexcept;

/// The ranges of identifiers a station receives, in the order they were given; ranges may overlap, and the
/// first one counts. Realtime safe; one thread.
class RangeFilter {
 public:
  static constexpr std::size_t kMostRanges = 64;

  /// Appends a range. False, and nothing has changed, when `check` finds a problem or there are
  /// `kMostRanges`.
  bool add(const ReceiveRange& range) noexcept;

  /// Position (0..kMostRanges-1) of the first range that takes the frame; nothing when none does.
  std::optional<std::uint8_t> match(const can::Frame& frame) const noexcept;

  /// A range that was added.
  const ReceiveRange& range(std::uint8_t at) const noexcept { return ranges_[at]; }

  /// Number of ranges; without one nothing is received.
  std::size_t size() const noexcept { return size_; }

 private:
  std::array<ReceiveRange, kMostRanges> ranges_ = {};
  std::size_t size_ = 0;
};

}  // namespace layer2
