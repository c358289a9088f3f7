#pragma once

#include <span>

#include "daemon/segment/protocol.h"

namespace cansyncd {

/// Every protocol that this daemon speaks; the first is what a file without `bus.protocol` means.
std::span<const ProtocolInfo* const> protocols() noexcept;

}  // namespace cansyncd
