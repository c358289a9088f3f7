#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <type_traits>

namespace rt {

/// Hands the newest value from one writer thread to one reader thread; older ones are overwritten.
///
/// A triple buffer: writer and reader each own one buffer, the third changes hands. Both sides are wait-free
/// and realtime safe, and the reader always sees a whole value.
template <class T>
class LatestValue {
  static_assert(std::is_trivially_copyable_v<T>, "values cross threads as plain bytes");

 public:
  LatestValue() = default;
  LatestValue(const LatestValue&) = delete;
  LatestValue& operator=(const LatestValue&) = delete;

  /// Writer: makes `value` the newest.
  void write(const T& value) noexcept {
    buffers_[back_] = value;
    back_ = middle_.exchange(static_cast<std::uint8_t>(back_ | kFresh), std::memory_order_acq_rel) & kIndex;
  }

  /// Reader: copies the newest value into `out` if it was written after the last successful `read`; otherwise
  /// returns false and leaves `out` untouched.
  bool read(T& out) noexcept {
    if ((middle_.load(std::memory_order_relaxed) & kFresh) == 0) return false;
    front_ = middle_.exchange(front_, std::memory_order_acq_rel) & kIndex;
    out = buffers_[front_];
    return true;
  }

 private:
  static constexpr std::uint8_t kIndex = 0x03;
  static constexpr std::uint8_t kFresh = 0x04;  ///< the middle buffer was not read yet

  std::array<T, 3> buffers_ = {};
  std::atomic<std::uint8_t> middle_{1};
  std::uint8_t back_ = 0;   ///< writer's buffer
  std::uint8_t front_ = 2;  ///< reader's buffer
};

}  // namespace rt
