#pragma once

#include <array>
#include <chrono>
#include <cstdint>

/// The data types of PLC programs, as the manual of the CANsync option module writes them. Function blocks
/// have their inputs and outputs as public members with the manual's names. Set the inputs, call `call()`
/// once in each cycle of the program, look at the outputs.
///
/// Calls never wait for an answer, only for a daemon that takes no samples: at most 1 s for each. One thread
/// at a time may use a block; several blocks may be used by several threads. The Client must outlive its
/// blocks. `_BASE`, the module's memory, is the Client here.
namespace cansync::client::function_blocks {

using BOOL = bool;
using BYTE = std::uint8_t;
using WORD = std::uint16_t;
using DWORD = std::uint32_t;
using SINT = std::int8_t;
/// Its value, -128..127.
constexpr int number(SINT value) noexcept {
  return value;  // NOLINT(bugprone-signed-char-misuse): a number of eight bits, no character
}

using USINT = std::uint8_t;
using INT = std::int16_t;
using UINT = std::uint16_t;
using DINT = std::int32_t;
using UDINT = std::uint32_t;
using TIME = std::chrono::milliseconds;

using SINT_4_BMARRAY = std::array<SINT, 4>;
using BOOL_4_BMARRAY = std::array<BOOL, 4>;
using BYTE_32_BMARRAY = std::array<BYTE, 32>;
using DINT_8_BMARRAY = std::array<DINT, 8>;
using DINT_16_BMARRAY = std::array<DINT, 16>;
using CANsync_RD_BMARRAY = std::array<DINT_16_BMARRAY, 32>;  ///< [slave][actual value]
using CANsync_UPDOWN_BMARRAY = std::array<DINT, 2048>;

/// Clock of monitoring times. Every `call` takes the time as an argument, so that tests and simulations can
/// give their own.
using Clock = std::chrono::steady_clock;

/// Number of slaves an automatic cursor goes through, and "not assigned" of slave numbers.
inline constexpr SINT kAutomaticNumber = -128;

}  // namespace cansync::client::function_blocks
