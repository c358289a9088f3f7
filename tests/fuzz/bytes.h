#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

/// Turns the bytes of a fuzzer into numbers and texts, from the front to the back; behind the end everything
/// is zero, so that every input means something.
namespace fuzz {

class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) noexcept : left_(data, size) {}

  bool empty() const noexcept { return left_.empty(); }
  std::size_t size() const noexcept { return left_.size(); }

  /// The next sizeof(T) bytes as a number, lowest byte first.
  template <class T>
  T number() noexcept {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i) value |= std::uint64_t{byte()} << (8 * i);
    return static_cast<T>(value);
  }
  std::uint8_t byte() noexcept {
    if (left_.empty()) return 0;
    const std::uint8_t value = left_.front();
    left_ = left_.subspan(1);
    return value;
  }
  bool flag() noexcept { return (byte() & 1) != 0; }

  /// A number 0..limit-1; `limit` 1..65536.
  unsigned below(unsigned limit) noexcept {
    return (limit <= 256 ? byte() : number<std::uint16_t>()) % limit;
  }

  /// At most the next `most` bytes.
  std::span<const std::uint8_t> take(std::size_t most) noexcept {
    const auto taken = left_.first(std::min(most, left_.size()));
    left_ = left_.subspan(taken.size());
    return taken;
  }

 private:
  std::span<const std::uint8_t> left_;
};

/// The whole input as text.
inline std::string text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

}  // namespace fuzz
