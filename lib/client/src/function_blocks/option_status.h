#pragma once

#include <cansync/function_blocks/types.h>

/// Values of w_OPTION_STATUS (M 3.2.2.3). Internal to the function blocks.
namespace cansync::client::function_blocks {

inline constexpr WORD kStartUp = 0x0001;
inline constexpr WORD kInitialisationPossible = 0x0002;
inline constexpr WORD kWaiting = 0x0003;
inline constexpr WORD kSettingUp = 0x0043;
inline constexpr WORD kActive = 0x0080;
inline constexpr WORD kSettingUpSlave = 0x0013;  // M 3.2.3.3
inline constexpr WORD kActiveSlave = 0x0020;

/// Synchronous operation has been set up, or is active.
constexpr bool is_synchronous(WORD option_status) noexcept {
  return option_status == kSettingUp || option_status == kActive;
}

}  // namespace cansync::client::function_blocks
