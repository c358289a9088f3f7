#pragma once

#include <string_view>

#include "can/bus.h"

/// Names of the bus's states, as topics, command line and recordings tell them. Realtime safe.
namespace can {

/// E.g. "bus-off".
std::string_view name(ControllerState state) noexcept;
/// E.g. "wrong-bit-rate".
std::string_view name(LinkState state) noexcept;
/// E.g. "unacknowledged".
std::string_view name(Delivery delivery) noexcept;
/// E.g. "kernel".
std::string_view name(TimestampSource source) noexcept;

}  // namespace can
