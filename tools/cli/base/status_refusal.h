#pragma once

#include <cansync/topics.h>
#include <fmt/format.h>

#include <string>

/// Words for a slave that refuses its status word.
namespace cansync::cli {

/// What mends it.
inline constexpr const char* kStatusRefusalRemedy =
    "set startup.status_parameter, or the slave's status_parameter, to the number in the drive's parameter "
    "list; then restart cansyncd";

/// Which slave refuses which parameter, and how.
inline std::string status_refusal(const client::SlaveStatus& slave) {
  return fmt::format(
      "slave {} '{}' refuses its status word, parameter {}, with error 0x{:04X}: whether it is "
      "synchronized cannot be known",
      slave.slave, slave.name, slave.status_parameter, slave.status_error);
}

}  // namespace cansync::cli
