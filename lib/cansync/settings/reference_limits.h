#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>

#include "cansync/telegram/mapping.h"
#include "cansync/telegram/numbers.h"

/// What is plausible for reference values. Plain values; safe on the realtime thread.
namespace cansync {

/// The first value of a release must be near an actual value of a slave:
/// |value - (actual * factor + offset)| <= distance, all in numbers of the reference value.
struct StartWithin {
  SlaveNumber slave;       ///< whose actual value
  std::uint8_t value = 0;  ///< 0..7
  bool is_signed = true;   ///< of the actual value's number
  double factor = 1.0;     ///< from the actual value's number
  double offset = 0.0;     ///< likewise
  double distance = 0.0;   ///< 0 or more
  friend bool operator==(const StartWithin&, const StartWithin&) = default;
};

/// Limits of one reference value, as numbers: raw values read with the width of the mapping in force and
/// their sign (`number_of`). A default is no limit.
struct ReferenceLimits {
  static constexpr std::int64_t kNone = std::numeric_limits<std::int64_t>::max();

  bool is_signed = true;          ///< of the reference value's number
  std::int64_t minimum = -kNone;  ///< least number that is sent
  std::int64_t maximum = kNone;   ///< greatest number that is sent
  std::int64_t max_step = kNone;  ///< greatest difference to the number that was sent last; 0 or more
  std::optional<StartWithin> start_within;  ///< nothing: a release begins anywhere

  /// True when there is a limit of any kind.
  constexpr bool any() const noexcept {
    return minimum != -kNone || maximum != kNone || max_step != kNone || start_within.has_value();
  }
  friend bool operator==(const ReferenceLimits&, const ReferenceLimits&) = default;
};

/// Of reference values 0..7.
using AllReferenceLimits = std::array<ReferenceLimits, kValues>;

/// Which limit a reference value was beyond.
enum class LimitKind : std::uint8_t {
  minimum,
  maximum,
  max_step,
  start_within,
  start_unknown,  ///< `start_within`, and its actual value has not come lately
};

/// A reference value that was beyond a limit. Numbers as in `ReferenceLimits`.
struct LimitViolation {
  LimitKind kind = LimitKind::minimum;
  std::uint8_t value = 0;   ///< reference value 0..7
  std::int64_t number = 0;  ///< as it was given
  std::int64_t against =
      0;  ///< max_step: the number that was sent last; start_within: that of the actual value
  std::int64_t limit = 0;  ///< minimum, maximum, max_step: the limit
};

}  // namespace cansync
