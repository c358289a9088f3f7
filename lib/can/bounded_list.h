#pragma once

#include <array>
#include <cstddef>

namespace can {

/// A bounded list in the order of arrival; for few elements. Realtime safe; one thread.
template <class T, std::size_t N>
class BoundedList {
 public:
  static constexpr std::size_t kMost = N;

  /// Elements, 0..N.
  std::size_t size() const noexcept { return size_; }
  /// There is no room.
  bool full() const noexcept { return size_ == N; }
  /// Element `i`, below `size()`.
  T& operator[](std::size_t i) noexcept { return elements_[i]; }
  const T& operator[](std::size_t i) const noexcept { return elements_[i]; }
  /// Appends; there must be room.
  void push(const T& element) noexcept { elements_[size_++] = element; }
  /// Takes element `at` out; it must be there.
  void erase(std::size_t at) noexcept {
    for (std::size_t i = at + 1; i < size_; ++i) elements_[i - 1] = elements_[i];
    --size_;
  }

 private:
  std::array<T, N> elements_ = {};
  std::size_t size_ = 0;
};

}  // namespace can
