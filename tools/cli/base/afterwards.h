#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "system/descriptor.h"

namespace cansync::cli {

/// Has commands run when this process ends without a word, also when it is killed: a shell in a session of its own
/// waits for it. One thread.
class Afterwards {
 public:
  /// Each command is a program, looked up in PATH, and its arguments; each is tried whatever the one before did. Throws
  /// std::system_error.
  explicit Afterwards(const std::vector<std::vector<std::string>>& commands);
  /// The commands are not run.
  ~Afterwards();
  Afterwards(const Afterwards&) = delete;
  Afterwards& operator=(const Afterwards&) = delete;

 private:
  sys::Descriptor end_;  ///< of a pipe that the shell reads; it closes with this process
  pid_t shell_ = 0;
};

}  // namespace cansync::cli
