#pragma once

#include <cansync/function_blocks/types.h>

#include <array>
#include <cstddef>
#include <cstdint>

/// How FC 65 and FC 66 show a frame (Helmholz 7.2.2). Internal to the function blocks.
namespace cansync::client::function_blocks {

// Bits of RTRLEN.
inline constexpr WORD kLengthBits = 0x0F;
inline constexpr WORD kRemoteBit = 0x40;
inline constexpr WORD kHighPriorityBit = 0x80;

/// The first `length` bytes of four words, high byte first; 0 behind them.
inline std::array<std::uint8_t, 8> bytes_of(const std::array<WORD, 4>& words, std::size_t length) noexcept {
  std::array<std::uint8_t, 8> bytes = {};
  for (std::size_t i = 0; i < length && i < bytes.size(); ++i)
    bytes[i] = static_cast<std::uint8_t>(i % 2 == 0 ? words[i / 2] >> 8 : words[i / 2]);
  return bytes;
}

/// Word `number` of a frame's bytes.
inline WORD word_of(const std::array<std::uint8_t, 8>& bytes, std::size_t number) noexcept {
  return static_cast<WORD>(bytes[2 * number] << 8 | bytes[2 * number + 1]);
}

}  // namespace cansync::client::function_blocks
