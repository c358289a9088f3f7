#pragma once

#include "types.h"

/// RETVAL of the function blocks of a CAN 300 PRO (Helmholz 8). The manual has no number for success and
/// assigns none to blocks: 0 is success, and each block says what it gives.
namespace cansync::client::function_blocks::module_code {

inline constexpr INT done = 0;
inline constexpr INT not_ready = static_cast<INT>(0x80F1);  ///< no daemon, in stop, or no address
inline constexpr INT in_use = static_cast<INT>(0x80F2);     ///< too many requests of the connection are open
inline constexpr INT node_invalid = static_cast<INT>(0x81E1);   ///< the number of a node is not possible
inline constexpr INT input_invalid = static_cast<INT>(0x82E2);  ///< a function, or another input, is not

}  // namespace cansync::client::function_blocks::module_code
