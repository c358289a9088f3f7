#pragma once

#include <span>
#include <string>

#include "cansync/config/file.h"

namespace cansyncd {

/// Reads and checks a configuration completely: the file, and what stands behind it. Main thread.
ConfigFile load_checked(const config::Source& source, std::span<const std::string> overrides);

}  // namespace cansyncd
