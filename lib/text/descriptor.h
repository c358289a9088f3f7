#pragma once

#include <unistd.h>

namespace text {

/// Owns an open descriptor of a file or socket and closes it; below 0: none. Not copied. Any thread, one at a
/// time.
class Descriptor {
 public:
  explicit Descriptor(int number) noexcept : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int number() const noexcept { return number_; }

 private:
  int number_;
};

}  // namespace text
