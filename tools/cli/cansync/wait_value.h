#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "cli/base/session.h"

/// `wait value`: until an actual value of a slave is as wanted, and what compares values elsewhere. Main
/// thread only.
namespace cansync::cli {

/// How a value is compared.
enum class Comparison : std::uint8_t { less, at_most, equal, not_equal, at_least, more };

/// "<", "<=", "=", "==", "!=", ">=", ">". Throws UsageError.
Comparison parse_comparison(std::string_view text);

bool holds(double value, Comparison comparison, double wanted) noexcept;

/// What a value is to be; slave and value are looked up when a daemon is there.
struct Wanted {
  std::string slave;
  std::string value;  ///< an actual value or a parameter, by name or number
  std::string sign;   ///< `comparison` as typed
  Comparison comparison = Comparison::equal;
  double number = 0;
  bool raw = false;  ///< `value` is a number
};

/// SLAVE VALUE COMPARISON NUMBER; `what` begins the error of another number of words. Throws UsageError.
Wanted parse_wanted(const std::vector<std::string>& words, std::string_view what);

/// What came of looking at a value.
struct ValueSeen {
  bool reached = false;
  bool fresh = false;  ///< one came while it was looked at
  std::string text;    ///< "position is 3 mm", what was seen last
};

/// Looks at the telegrams that come from now on until one is as wanted, with `once` only at the first, at
/// most until `end` or Ctrl-C; also for the daemon. Throws UsageError.
ValueSeen look_at_value(Session& session, const Wanted& wanted, std::chrono::steady_clock::time_point end,
                        bool once);

/// `words`: SLAVE VALUE COMPARISON NUMBER, the number in the value's unit when VALUE is a name, raw when it
/// is a number. Waits at most `--timeout`, also for the daemon.
ExitCode wait_value(Session& session, const std::vector<std::string>& words);

}  // namespace cansync::cli
