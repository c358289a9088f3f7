#include "layer2/range_filter.h"

namespace layer2 {

RangeProblem check(const ReceiveRange& range) noexcept {
  const std::uint32_t largest = range.extended ? can::kExtendedIdentifierMask : can::kStandardIdentifierMask;
  if (range.first > largest || range.last > largest) return RangeProblem::identifier_too_large;
  return range.first > range.last ? RangeProblem::reversed : RangeProblem::none;
}

bool takes(const ReceiveRange& range, const can::Frame& frame) noexcept {
  if (frame.error || frame.extended != range.extended) return false;
  if (range.kinds == FrameKinds::data && frame.remote) return false;
  if (range.kinds == FrameKinds::remote && !frame.remote) return false;
  const std::uint32_t identifier = frame.identifier();
  return range.first <= identifier && identifier <= range.last;
}

bool takes(const NodeFilter& filter, const can::Frame& frame) noexcept {
  if (frame.error || frame.extended != filter.extended) return false;
  const std::uint32_t node = frame.identifier() % 128;
  return node == filter.node || node == 0;
}

bool RangeFilter::add(const ReceiveRange& range) noexcept {
  if (size_ == kMostRanges || check(range) != RangeProblem::none) return false;
  ranges_[size_++] = range;
  return true;
}

std::optional<std::uint8_t> RangeFilter::match(const can::Frame& frame) const noexcept {
  for (std::size_t i = 0; i < size_; ++i) {
    if (takes(ranges_[i], frame)) return static_cast<std::uint8_t>(i);
  }
  return std::nullopt;
}

}  // namespace layer2
