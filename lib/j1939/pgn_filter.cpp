#include "j1939/pgn_filter.h"

namespace j1939 {

bool PgnFilter::add(const PgnRange& range) noexcept {
  if (size_ == kMostRanges) return false;
  ranges_[size_++] = range;
  return true;
}

std::optional<std::uint8_t> PgnFilter::match(Pgn number, Address source) const noexcept {
  for (std::size_t i = 0; i < size_; ++i) {
    const PgnRange& range = ranges_[i];
    if (number < range.first || number > range.last) continue;
    if (range.source && *range.source != source) continue;
    return static_cast<std::uint8_t>(i);
  }
  return std::nullopt;
}

}  // namespace j1939
