#pragma once

#include <chrono>

namespace gateway {

/// After so long something has certainly gone wrong, also on a loaded computer under a sanitizer. A test that waits for
/// something else than time gives up then; it judges no time by it.
inline constexpr std::chrono::seconds kLongWait{120};

}  // namespace gateway
