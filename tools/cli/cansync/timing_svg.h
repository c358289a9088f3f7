#pragma once

#include <string>
#include <string_view>

#include "cli/cansync/timing_report.h"

namespace cansync::cli {

/// One interval as a diagram (SVG 1.1, UTF-8): a lane for the SYNC wake-up and for each slot, over a time
/// axis in us; in each lane the earliest, mean and latest start seen, the planned and the latest allowed
/// start, and the numbers. Shades of grey alone. `date` stands in the title. Pure function.
std::string timing_svg(const TimingReport& report, std::string_view date);

}  // namespace cansync::cli
