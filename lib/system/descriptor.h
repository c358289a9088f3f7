#pragma once

#include <unistd.h>

#include <utility>

namespace sys {

/// Owns an open descriptor of a file or socket and closes it; below 0: none. Not copied. Any thread, one at a
/// time; nothing allocates or throws.
class Descriptor {
 public:
  explicit Descriptor(int number = -1) noexcept : number_(number) {}
  ~Descriptor() { reset(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  /// Closes what is open and takes `number` over.
  void reset(int number = -1) noexcept {
    const int before = std::exchange(number_, number);
    if (before >= 0) ::close(before);
  }
  bool is_open() const noexcept { return number_ >= 0; }
  int number() const noexcept { return number_; }

 private:
  int number_;
};

}  // namespace sys
