#pragma once

#include <string>
#include <string_view>

#include "cli/record/plot_data.h"

namespace cansync::cli {

/// What a plot is drawn as.
enum class PlotFormat : unsigned char { svg, png };

/// The commands for gnuplot that draw `data`, one panel a value with a curve for each slave; the picture goes
/// to gnuplot's standard output. Names from the recording cannot be anything but text in it. Pure.
std::string plot_script(const PlotData& data, std::string_view title, PlotFormat format);

}  // namespace cansync::cli
