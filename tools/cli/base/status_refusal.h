#pragma once

#include <cansync/topics.h>
#include <fmt/format.h>

#include <string>

/// Words for a slave that does not give its status word.
namespace cansync::cli {

/// What fixes it.
inline constexpr const char* kStatusRefusalRemedy =
    "set startup.status_parameter, or the slave's status_parameter, to the number in the drive's parameter "
    "list; then restart cansyncd";

/// It answers, and its status word was refused with an error or never came.
inline bool lacks_status_word(const client::SlaveStatus& slave) {
  return slave.status_error != 0 || (slave.responds && !slave.status_known);
}

/// The same without the slave and its parameter's number: what several slaves have in common.
inline std::string status_refusal_alike(const client::SlaveStatus& slave) {
  const std::string how =
      slave.status_error != 0
          ? fmt::format("the status word is refused with error 0x{:04X}", slave.status_error)
          : std::string("no status word has come");
  return how + ": whether they are synchronized cannot be known";
}

/// Which slave lacks which parameter, and how.
inline std::string status_refusal(const client::SlaveStatus& slave) {
  const std::string how =
      slave.status_error != 0
          ? fmt::format("refuses its status word, parameter {}, with error 0x{:04X}", slave.status_parameter,
                        slave.status_error)
          : fmt::format("answers, but has not given its status word, parameter {}", slave.status_parameter);
  return fmt::format("slave {} '{}' {}: whether it is synchronized cannot be known", slave.slave, slave.name,
                     how);
}

}  // namespace cansync::cli
