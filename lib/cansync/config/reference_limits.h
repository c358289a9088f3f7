#pragma once

#include <span>
#include <string>
#include <vector>

#include "cansync/config/draft.h"

/// Limits of reference values, from the options in the value's unit to numbers. Main thread only.
namespace cansyncd {

/// What is allowed for reference.start_within.
inline constexpr std::string_view kStartWithinWords =
    "a list of three: number or name of a slave, number or name of its actual value, and a distance of 0 or "
    "more";

/// True for such a list; who is meant is looked at by `finish_reference_limits`.
bool takes_start_within(const Draft& draft, const Value& value);

/// Something wrong with an option of [[reference]].
struct LimitProblem {
  std::string key;  ///< "reference.0.minimum"
  std::string text;
};

/// Fills `Config::reference_limits` and `ProcessSettings::reference_limits` of the draft, whose other options
/// are complete. Returns what is wrong.
std::vector<LimitProblem> finish_reference_limits(Draft& draft);

}  // namespace cansyncd
