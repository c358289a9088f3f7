#pragma once

#include <string_view>

#include "can/frame.h"

namespace cansync::cli {

/// A frame as can-utils write it: `123#0102FF`, `123#01.02.FF`, `18DAF110#` (eight digits: 29 bits), `123#R3`
/// (remote, with a length). Throws UsageError with the column.
can::Frame parse_sent_frame(std::string_view text);

}  // namespace cansync::cli
