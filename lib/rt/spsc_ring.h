#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <type_traits>

namespace rt {

/// Bounded queue from one producer thread to one consumer thread.
///
/// All memory is taken (and touched) in the constructor. Every other function is wait-free and realtime safe;
/// `try_push` belongs to the producer, `try_pop` to the consumer.
template <class T>
// NOLINTNEXTLINE(clang-analyzer-optin.performance.Padding): the two ends stand in cache lines of their own
class SpscRing {
  static_assert(std::is_trivially_copyable_v<T>, "elements cross threads as plain bytes");
  static_assert(std::atomic<std::size_t>::is_always_lock_free);

 public:
  /// Room for exactly `capacity` elements; 0 counts as 1.
  explicit SpscRing(std::size_t capacity)
      : slots_(capacity == 0 ? 2 : capacity + 1), elements_(std::make_unique<T[]>(slots_)) {}
  SpscRing(const SpscRing&) = delete;
  SpscRing& operator=(const SpscRing&) = delete;

  /// Producer: appends a copy of `value`; false when there is no room, and then nothing has changed.
  bool try_push(const T& value) noexcept {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    const std::size_t after = following(tail);
    if (after == head_.load(std::memory_order_acquire)) return false;
    elements_[tail] = value;
    tail_.store(after, std::memory_order_release);
    return true;
  }

  /// Consumer: takes the oldest element into `out`; false when there is none, and then `out` is untouched.
  bool try_pop(T& out) noexcept {
    const std::size_t head = head_.load(std::memory_order_relaxed);
    if (head == tail_.load(std::memory_order_acquire)) return false;
    out = elements_[head];
    head_.store(following(head), std::memory_order_release);
    return true;
  }

  /// Elements in the queue. The producer may find fewer than this a moment later, the consumer more.
  std::size_t size() const noexcept {
    const std::size_t head = head_.load(std::memory_order_acquire);
    const std::size_t tail = tail_.load(std::memory_order_acquire);
    return tail >= head ? tail - head : tail + slots_ - head;
  }

  /// Room that is left. What the producer sees here it can surely push.
  std::size_t room() const noexcept { return capacity() - size(); }

  std::size_t capacity() const noexcept { return slots_ - 1; }

 private:
  /// One slot always stays empty, which tells a full queue from an empty one.
  std::size_t following(std::size_t position) const noexcept {
    return position + 1 == slots_ ? 0 : position + 1;
  }

  static constexpr std::size_t kCacheLine = 64;
  const std::size_t slots_;
  const std::unique_ptr<T[]> elements_;
  alignas(kCacheLine) std::atomic<std::size_t> head_{0};  ///< next to pop; written by the consumer
  alignas(kCacheLine) std::atomic<std::size_t> tail_{0};  ///< next to fill; written by the producer
};

}  // namespace rt
