#pragma once

#include <cstdint>

#include "can/frame.h"

namespace can {

/// What a filter wants of a flag of a frame.
enum class FlagFilter : std::uint8_t { clear, set, either };

/// Takes the frames whose identifier agrees with `identifier` in the bits of `mask` and whose flags are as
/// wanted. The identifier of a standard frame is compared as one of 29 bits with the upper ones 0.
struct FrameFilter {
  std::uint32_t identifier = 0;                  ///< 0..0x1FFFFFFF
  std::uint32_t mask = kExtendedIdentifierMask;  ///< all bits: this identifier alone; 0: any
  FlagFilter extended = FlagFilter::clear;       ///< `clear`: 11-bit identifiers alone; `set`: 29-bit ones
  FlagFilter remote = FlagFilter::clear;         ///< `clear`: data frames alone; `set`: remote frames
  friend bool operator==(const FrameFilter&, const FrameFilter&) = default;
};

}  // namespace can
