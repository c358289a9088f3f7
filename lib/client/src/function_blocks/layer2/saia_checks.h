#pragma once

#include <cansync/function_blocks/types.h>

/// Checks that SFB 400 to 413 share. Internal to the function blocks.
namespace cansync::client::function_blocks {

/// Why a PortID is refused.
inline constexpr const char* kOnlyPort = "client: PortID: allowed 0";

/// The number of an organisation block for interrupts (Saia 4.2).
constexpr bool is_routine(INT number) noexcept {
  return number >= 40 && number <= 47;
}

}  // namespace cansync::client::function_blocks
