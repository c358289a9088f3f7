#pragma once

#include "../types.h"

/// Status and RetVal of the function blocks SFB 400 to 413 (Saia 4.2). 8330 and 8331, write-protected target,
/// never come: a target is the program's own memory.
namespace cansync::client::function_blocks::can_status {

inline constexpr WORD done = 0x0000;
inline constexpr WORD no_data = 0x8180;           ///< nothing was received yet
inline constexpr WORD in_execution = 0x8181;      ///< a job is accepted, and on its way
inline constexpr WORD aborted = 0x8182;           ///< a job was aborted
inline constexpr WORD wrong_length = 0x8185;      ///< DLC
inline constexpr WORD wrong_identifier = 0x8186;  ///< identifier; SFB 410: target memory
inline constexpr WORD wrong_port = 0x8187;        ///< PortID
inline constexpr WORD no_queue = 0x8188;
inline constexpr WORD wrong_configuration = 0x8189;  ///< of a data mapping
inline constexpr WORD wrong_parameter = 0x8190;      ///< SFB 400 and 401: memory
inline constexpr WORD wrong_bit_rate = 0x8191;
inline constexpr WORD address_taken = 0x8192;  ///< in the process image
inline constexpr WORD refused = 0x80A0;        ///< the daemon is gone, in stop, or does not do it
inline constexpr WORD internal = 0x80A1;       ///< of a data mapping
inline constexpr WORD denied = 0x80C0;         ///< access to a message object
inline constexpr WORD full = 0x80C2;           ///< full queue, overrun, or a job is pending
inline constexpr WORD no_memory = 0x80C3;      ///< larger than the connection allows
inline constexpr WORD timed_out = 0x80C4;      ///< a job
inline constexpr WORD block_number = 0x8F33;   ///< no data block can have this number
inline constexpr WORD block_missing = 0x8F3A;  ///< the data block is not loaded

}  // namespace cansync::client::function_blocks::can_status
