#pragma once

#include <array>
#include <cstdint>

namespace cansyncd {

/// Names one start of the daemon. All zero: none.
using DaemonIdentity = std::array<std::uint8_t, 16>;

/// 16 random bytes: no two starts have the same. Throws std::system_error when the system gives none.
DaemonIdentity random_daemon_identity();

}  // namespace cansyncd
