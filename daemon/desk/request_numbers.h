#pragma once

#include <bitset>
#include <cstdint>

namespace cansyncd {

/// Which request numbers of one client were used, so that a request that arrives twice is not executed twice.
/// Remembers the newest `kWidth`; anything older counts as used. Not thread safe.
class RequestNumbers {
 public:
  /// Requests of different kinds travel on different topics, so they may arrive in another order than they
  /// were numbered, by less than this.
  static constexpr std::uint64_t kWidth = 1024;

  /// Uses a number; false: it was used before, or is too far behind the highest one.
  bool use(std::uint64_t number) noexcept {
    if (!any_ || number > highest_) {
      // What the window moves over is new again.
      const std::uint64_t moved = any_ ? number - highest_ : kWidth;
      if (moved >= kWidth) {
        used_.reset();
      } else {
        for (std::uint64_t i = 1; i <= moved; ++i) used_.reset((highest_ + i) % kWidth);
      }
      highest_ = number;
      any_ = true;
    } else if (highest_ - number >= kWidth || used_.test(number % kWidth)) {
      return false;
    }
    used_.set(number % kWidth);
    return true;
  }

  std::uint64_t highest() const noexcept { return highest_; }

 private:
  std::bitset<kWidth> used_;
  std::uint64_t highest_ = 0;
  bool any_ = false;
};

}  // namespace cansyncd
