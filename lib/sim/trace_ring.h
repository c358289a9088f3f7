#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace sim {

/// A bounded queue from one writing thread to one reading thread, wait-free on both sides. All memory is
/// taken at construction. `T` is copied and must not throw when it is.
template <class T>
class TraceRing {
 public:
  explicit TraceRing(std::size_t capacity) : slots_(capacity + 1) {}

  /// Writing thread: adds `value`; false when there is no room.
  bool push(const T& value) noexcept {
    const std::size_t at = written_.load(std::memory_order_relaxed);
    const std::size_t next = following(at);
    if (next == read_.load(std::memory_order_acquire)) return false;
    slots_[at] = value;
    written_.store(next, std::memory_order_release);
    return true;
  }

  /// Reading thread: takes the oldest value; false when there is none.
  bool pop(T& value) noexcept {
    const std::size_t at = read_.load(std::memory_order_relaxed);
    if (at == written_.load(std::memory_order_acquire)) return false;
    value = slots_[at];
    read_.store(following(at), std::memory_order_release);
    return true;
  }

 private:
  std::size_t following(std::size_t at) const noexcept { return at + 1 == slots_.size() ? 0 : at + 1; }

  static constexpr std::size_t kCacheLine = 64;
  std::vector<T> slots_;
  alignas(kCacheLine) std::atomic<std::size_t> written_{0};
  alignas(kCacheLine) std::atomic<std::size_t> read_{0};
};

}  // namespace sim
