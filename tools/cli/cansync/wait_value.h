#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "cli/base/session.h"

/// `wait value`: until an actual value of a slave is as wanted. Main thread only.
namespace cansync::cli {

/// How a value is compared.
enum class Comparison : std::uint8_t { less, at_most, equal, not_equal, at_least, more };

/// "<", "<=", "=", "==", "!=", ">=", ">". Throws UsageError.
Comparison parse_comparison(std::string_view text);

bool holds(double value, Comparison comparison, double wanted) noexcept;

/// `words`: SLAVE VALUE COMPARISON NUMBER, the number in the value's unit when VALUE is a name, raw when it
/// is a number. Waits at most `--timeout`, also for the daemon.
ExitCode wait_value(Session& session, const std::vector<std::string>& words);

}  // namespace cansync::cli
