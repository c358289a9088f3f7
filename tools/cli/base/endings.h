#pragma once

#include <stdexcept>
#include <string>

#include "cli/base/exit_codes.h"

namespace cansync::cli {

/// A verb ends with this code; what to say is in `what()`.
class Ended : public std::runtime_error {
 public:
  Ended(ExitCode code, const std::string& text) : std::runtime_error(text), code_(code) {}
  ExitCode code() const noexcept { return code_; }

 private:
  ExitCode code_;
};

/// The exit code of a verb that ended with this exception.
ExitCode code_of(const std::exception& error) noexcept;

}  // namespace cansync::cli
