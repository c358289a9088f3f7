#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace layer2 {

/// What becomes of an element that comes to a full queue.
enum class Overflow : std::uint8_t {
  delete_oldest,  ///< it is taken; the oldest element is deleted (Helmholz)
  refuse_newest,  ///< it is not taken (Saia)
};

/// A queue of a depth that can be changed up to what it was made for. An element lost by its being full sets
/// the overflow bit, which stays until it is reset. Memory is allocated by the constructor alone; the rest is
/// realtime safe. One thread.
template <class T>
class BoundedQueue {
 public:
  /// What became of an element.
  struct Pushed {
    bool taken = true;
    std::optional<T> deleted;  ///< the oldest element, which had to go for it
  };

  /// Room for `depth` elements, at least 1, and at most for the larger of `depth` and `most`.
  explicit BoundedQueue(std::size_t depth, Overflow rule = Overflow::refuse_newest, std::size_t most = 0)
      : elements_(std::max<std::size_t>({depth, most, 1})),
        depth_(std::max<std::size_t>(depth, 1)),
        rule_(rule) {}

  /// Another depth and rule; a depth outside 1..most counts as the nearest inside, and elements beyond it
  /// stay.
  void set(std::size_t depth, Overflow rule) noexcept {
    depth_ = std::clamp<std::size_t>(depth, 1, elements_.size());
    rule_ = rule;
  }

  /// Elements that wait, 0..depth.
  std::size_t size() const noexcept { return size_; }
  /// Room for elements.
  std::size_t depth() const noexcept { return depth_; }
  /// Nothing waits.
  bool empty() const noexcept { return size_ == 0; }
  /// There is no more room.
  bool full() const noexcept { return size_ >= depth_; }
  /// At least half of the room is taken.
  bool half_full() const noexcept { return 2 * size_ >= depth_; }
  /// An element was lost since the last `reset_overflow`.
  bool overflowed() const noexcept { return overflowed_; }
  /// Takes the overflow bit back.
  void reset_overflow() noexcept { overflowed_ = false; }
  /// Elements lost since the start.
  std::uint64_t lost() const noexcept { return lost_; }

  /// The element at a place, 0 (the oldest)..size-1.
  T& operator[](std::size_t at) noexcept { return elements_[index(at)]; }
  const T& operator[](std::size_t at) const noexcept { return elements_[index(at)]; }

  /// Puts an element behind all others.
  Pushed push(const T& element) noexcept {
    Pushed result = make_room();
    if (result.taken) (*this)[size_++] = element;
    return result;
  }

  /// Puts an element in front of the one at `at` (0..size).
  Pushed insert(std::size_t at, const T& element) noexcept {
    Pushed result = make_room();
    if (!result.taken) return result;
    if (result.deleted && at > 0) --at;
    std::size_t place = size_++;
    for (; place > at; --place) (*this)[place] = (*this)[place - 1];
    (*this)[place] = element;
    return result;
  }

  /// Takes the oldest element, which must be there.
  T pop() noexcept {
    T element = (*this)[0];
    first_ = index(1);
    --size_;
    return element;
  }

  /// Takes the element at a place out; those behind it move up.
  void erase(std::size_t at) noexcept {
    if (at == 0) {
      (void)pop();
      return;
    }
    for (std::size_t i = at + 1; i < size_; ++i) (*this)[i - 1] = (*this)[i];
    --size_;
  }

  /// Forgets every element; the overflow bit stays.
  void clear() noexcept { size_ = 0; }

 private:
  /// For one more element, by the rule.
  Pushed make_room() noexcept {
    Pushed result;
    if (!full()) return result;
    overflowed_ = true;
    ++lost_;
    result.taken = rule_ == Overflow::delete_oldest;
    if (result.taken) result.deleted = pop();
    return result;
  }

  std::size_t index(std::size_t at) const noexcept {
    const std::size_t sum = first_ + at;
    return sum < elements_.size() ? sum : sum - elements_.size();
  }

  std::vector<T> elements_;
  std::size_t depth_;
  std::size_t first_ = 0;
  std::size_t size_ = 0;
  Overflow rule_;
  bool overflowed_ = false;
  std::uint64_t lost_ = 0;
};

}  // namespace layer2
