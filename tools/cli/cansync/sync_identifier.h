#pragma once

#include <cstdint>
#include <string>

#include "cli/base/output.h"

namespace cansync::cli {

/// The identifier of the SYNC frame as `--sync` gives it: hexadecimal with or without 0x; the default when `text` is empty. What may
/// have been meant as a decimal number is said as a remark. Throws UsageError.
std::uint32_t parse_sync_identifier(const std::string& text, Output& output);

}  // namespace cansync::cli
