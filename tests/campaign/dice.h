#pragma once

#include <cstddef>
#include <cstdint>

namespace cansyncd::campaign {

/// Random numbers that are the same on every machine for the same seed (splitmix64). Not thread safe.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) noexcept : state_(seed) {}

  /// 64 random bits.
  std::uint64_t next() noexcept {
    state_ += 0x9E3779B97F4A7C15u;
    std::uint64_t mixed = state_;
    mixed = (mixed ^ (mixed >> 30)) * 0xBF58476D1CE4E5B9u;
    mixed = (mixed ^ (mixed >> 27)) * 0x94D049BB133111EBu;
    return mixed ^ (mixed >> 31);
  }

  /// 0..n-1; n at least 1.
  std::uint64_t below(std::uint64_t n) noexcept { return next() % n; }

  /// low..high, both included.
  std::uint64_t between(std::uint64_t low, std::uint64_t high) noexcept {
    return low + below(high - low + 1);
  }

  /// True so many times in a thousand.
  bool chance(unsigned per_mille) noexcept { return below(1000) < per_mille; }

  /// One element of an array.
  template <class T, std::size_t Count>
  const T& one_of(const T (&items)[Count]) noexcept {
    return items[below(Count)];
  }

 private:
  std::uint64_t state_;
};

}  // namespace cansyncd::campaign
