#pragma once

#include <bit>
#include <chrono>
#include <cstdint>
#include <optional>

namespace cansync {

/// A number that is in its range by construction; `Tag` keeps different kinds apart.
template <class Tag, class Rep, Rep Max>
class BoundedNumber {
 public:
  static constexpr Rep max = Max;

  constexpr BoundedNumber() = default;

  /// The number, or nothing when `value` is over `max`.
  static constexpr std::optional<BoundedNumber> from(std::uint64_t value) noexcept {
    if (value > Max) return std::nullopt;
    return BoundedNumber(static_cast<Rep>(value));
  }

  /// The plain number, 0..`max`.
  constexpr Rep value() const noexcept { return value_; }

  friend constexpr auto operator<=>(BoundedNumber, BoundedNumber) = default;

 private:
  constexpr explicit BoundedNumber(Rep value) : value_(value) {}
  Rep value_ = 0;
};

/// Slave number on a segment, 0..31 (M 3.1.1).
using SlaveNumber = BoundedNumber<struct SlaveTag, std::uint8_t, 31>;
/// Parameter number, 0..4095 (M 3.2.1.3).
using ParameterNumber = BoundedNumber<struct ParameterTag, std::uint16_t, 4095>;
/// Element of a parameter, 0..7; 7 is the value (M 3.2.1.3).
using Element = BoundedNumber<struct ElementTag, std::uint8_t, 7>;
/// Byte offset or length in a transfer telegram, 0..4095 (M 3.2.1.3).
using BlockOffset = BoundedNumber<struct BlockOffsetTag, std::uint16_t, 4095>;

inline constexpr unsigned kSlaves = 32;
inline constexpr Element kValueElement = *Element::from(7);

/// Participant below the addressed slave; 0 is the slave itself (M 3.2.1.3, O 7.2.1).
struct SubSlave {
  std::uint16_t value = 0;  ///< 0..65535
  friend constexpr bool operator==(SubSlave, SubSlave) = default;
};

/// A set of slaves; bit n stands for slave n (M 3.2.1.3, action command).
struct SlaveMask {
  std::uint32_t bits = 0;  ///< as on the bus: bit n is slave n

  /// The 32 slaves of a segment, configured or not.
  static constexpr SlaveMask all() noexcept { return {0xFFFFFFFFu}; }
  /// This slave alone.
  static constexpr SlaveMask of(SlaveNumber slave) noexcept { return {1u << slave.value()}; }
  /// True when the slave belongs to the set.
  constexpr bool has(SlaveNumber slave) const noexcept { return ((bits >> slave.value()) & 1u) != 0; }
  /// Puts the slave in, or with `on` false takes it out; the others stay.
  constexpr void set(SlaveNumber slave, bool on = true) noexcept {
    const std::uint32_t bit = 1u << slave.value();
    bits = on ? (bits | bit) : (bits & ~bit);
  }
  /// True when no slave is in it: as an action's mask nobody would act.
  constexpr bool empty() const noexcept { return bits == 0; }
  friend constexpr bool operator==(SlaveMask, SlaveMask) = default;

  /// Goes through the slaves, the lowest first, as they were when it began.
  class Iterator {
   public:
    /// Goes through the bits of `left`; 0 is the end.
    constexpr explicit Iterator(std::uint32_t left) noexcept : left_(left) {}
    /// The lowest slave left. Not allowed at the end.
    constexpr SlaveNumber operator*() const noexcept {
      return *SlaveNumber::from(static_cast<unsigned>(std::countr_zero(left_)));
    }
    /// Leaves the lowest slave behind. Not allowed at the end.
    constexpr Iterator& operator++() noexcept {
      left_ &= left_ - 1;
      return *this;
    }
    friend constexpr bool operator==(Iterator, Iterator) = default;

   private:
    std::uint32_t left_;
  };
  /// For range-based loops: `for (const SlaveNumber slave : mask)`.
  constexpr Iterator begin() const noexcept { return Iterator(bits); }
  /// Behind the highest slave.
  constexpr Iterator end() const noexcept { return Iterator(0); }
};

/// Number of a SYNC interval, counted from 0 at the start of the timeline.
using IntervalNumber = std::uint64_t;

/// A span of time, and an instant after the SYNC edge of the running interval.
using Duration = std::chrono::nanoseconds;

/// The two process data channel pairs: WRC1/RDC1 and WRC2/RDC2.
enum class Channel : std::uint8_t { one = 0, two = 1 };
inline constexpr unsigned kChannels = 2;
/// Place of a channel in arrays of `kChannels`: 0 or 1.
constexpr unsigned index(Channel channel) noexcept {
  return static_cast<unsigned>(channel);
}

}  // namespace cansync
