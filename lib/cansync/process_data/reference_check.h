#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "cansync/settings/reference_limits.h"
#include "cansync/telegram/mapping.h"
#include "cansync/telegram/numbers.h"

namespace cansync {

/// The values that a telegram carries, by its mapping.
struct CarriedValues {
  std::uint8_t values = 0;  ///< bit n: value n
  std::uint8_t words = 0;   ///< bit n: of value n the low word alone
  friend constexpr bool operator==(const CarriedValues&, const CarriedValues&) = default;
};

/// An actual value for `StartWithin`.
struct ActualNumber {
  std::uint32_t raw = 0;  ///< as received
  bool word = false;      ///< it came as its low word alone
};

/// Where the check finds actual values.
class ActualSource {
 public:
  virtual ~ActualSource() = default;
  /// The newest actual value of a slave; nothing when it has not come lately, or is not mapped.
  virtual std::optional<ActualNumber> recent(SlaveNumber slave, std::uint8_t value) const noexcept = 0;
};

/// Checks reference values against their limits, right before they are taken into use: the last place before
/// the bus, which the values of every writer pass. Looks at all values that the telegram carries, also those
/// that keep an earlier value.
///
/// - `max_step` is the greatest difference between two values that follow each other on the bus. A gap does
///   not add to it: what a drive does meanwhile is not known, and after the gap it has one interval for the
///   way. It holds as long as active operation lasts, whoever writes.
/// - A release begins with the first value of active operation, after it was withdrawn (its writer has left,
///   was silent, or another one takes over), or after more than `kContinues` intervals without. Its first
///   value must satisfy `start_within`. After more than `kContinues` intervals this alone decides, because a
///   drive may be elsewhere by then; without `start_within` the value sent last still does.
///
/// Neither allocates nor throws; realtime safe. Not thread safe.
class ReferenceCheck {
 public:
  /// Intervals between two telegrams of one release, at most; drives extrapolate over a few.
  static constexpr IntervalNumber kContinues = 10;

  /// `limits`: of all reference values; copied.
  explicit ReferenceCheck(const AllReferenceLimits& limits) noexcept : limits_(limits) { note_limited(); }

  /// From the next value on. Values sent before stay known.
  void set_limits(std::uint8_t value, const ReferenceLimits& limits) noexcept;

  /// Active operation ends: values sent before count no longer.
  void forget() noexcept { sent_ = {}; }
  /// The release of a telegram was withdrawn: the next values begin one.
  void withdrawn(Channel channel) noexcept { withdrawn_[index(channel)] = true; }
  /// Values that passed were taken into use.
  void taken(Channel channel) noexcept { withdrawn_[index(channel)] = false; }

  /// The first value beyond a limit, of those that the telegram carries in interval `now`; nothing: all may be
  /// sent. `values`: all reference values as they would be in use.
  std::optional<LimitViolation> judge(Channel channel, CarriedValues carried, const Values& values,
                                      IntervalNumber now, const ActualSource& actual) const noexcept;
  /// The same for values that are already in use: minimum and maximum alone.
  std::optional<LimitViolation> judge_range(CarriedValues carried, const Values& values) const noexcept;

  /// The telegram with these values was handed to the bus.
  void sent(CarriedValues carried, const Values& values, IntervalNumber now) noexcept;

 private:
  struct Sent {
    bool known = false;
    bool word = false;
    std::uint32_t raw = 0;
    IntervalNumber interval = 0;
  };

  void note_limited() noexcept;
  std::optional<LimitViolation> out_of_range(std::uint8_t value, std::int64_t number) const noexcept;
  std::optional<LimitViolation> too_far(std::uint8_t value, std::int64_t number, bool withdrawn,
                                        IntervalNumber now, const ActualSource& actual) const noexcept;

  AllReferenceLimits limits_;
  unsigned limited_ = 0;  ///< bit n: value n has a limit
  std::array<Sent, kValues> sent_ = {};
  std::array<bool, kChannels> withdrawn_ = {};
};

}  // namespace cansync
