#include "can/frame_length.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>

static_assert(std::endian::native == std::endian::little, "bytes_of and message_of swap bytes");

namespace can {
namespace {

__extension__ using Wide = unsigned __int128;

constexpr unsigned kPolynomial = 0x4599;
constexpr unsigned kCrcBits = 15;
constexpr unsigned kMostCrcBytes = 13;  // 39 header bits of an extended frame in 5 bytes, and 8 data bytes

// kCrc[k][b]: what byte `b` followed by `k` zero bytes adds to the CRC. The CRC is linear and starts from 0,
// so the CRC of a message is the exclusive or over its bytes: independent look-ups instead of a chain.
using CrcTables = std::array<std::array<std::uint16_t, 256>, kMostCrcBytes>;

constexpr std::uint16_t shift_in_zeros(std::uint16_t crc, unsigned bits) {
  unsigned value = crc;
  for (unsigned i = 0; i < bits; ++i) {
    value <<= 1;
    if ((value & 0x8000u) != 0) value ^= 0x8000u | kPolynomial;
  }
  return static_cast<std::uint16_t>(value);
}

constexpr CrcTables kCrc = [] {
  CrcTables tables{};
  for (unsigned byte = 0; byte < 256; ++byte) {
    // A message bit enters at the top of the register: the byte's upper bits stand 7 places above it.
    unsigned crc = 0;
    for (unsigned bit = 8; bit-- > 0;) {
      const unsigned next = ((byte >> bit) & 1u) ^ (crc >> (kCrcBits - 1));
      crc = (crc << 1) & 0x7FFFu;
      if (next != 0) crc ^= kPolynomial;
    }
    tables[0][byte] = static_cast<std::uint16_t>(crc);
    for (unsigned k = 1; k < kMostCrcBytes; ++k) {
      tables[k][byte] = shift_in_zeros(tables[k - 1][byte], 8);
    }
  }
  return tables;
}();

// Bit stuffing as a state machine that eats a byte at a time. A state is the last level on the bus and how
// many bits of it stand in a row (1..4): five in a row are followed by a stuff bit at once.
struct Step {
  std::uint8_t state = 0;
  std::uint8_t stuffed = 0;
};
constexpr unsigned kMostInRow = 4;
constexpr std::size_t kStates = 8;  // two levels, 1..4 in a row
using StuffTable = std::array<std::array<Step, 256>, kStates>;

constexpr unsigned state_of(unsigned level, unsigned in_row) {
  return level * kMostInRow + in_row - 1;
}

constexpr Step eat(unsigned state, unsigned byte) {
  unsigned level = state / kMostInRow;
  unsigned in_row = state % kMostInRow + 1;
  unsigned stuffed = 0;
  for (unsigned bit = 8; bit-- > 0;) {
    const unsigned next = (byte >> bit) & 1u;
    in_row = next == level ? in_row + 1 : 1;
    level = next;
    if (in_row > kMostInRow) {
      ++stuffed;
      level ^= 1u;
      in_row = 1;
    }
  }
  return {static_cast<std::uint8_t>(state_of(level, in_row)), static_cast<std::uint8_t>(stuffed)};
}

constexpr StuffTable kStuff = [] {
  StuffTable table{};
  for (unsigned state = 0; state < table.size(); ++state) {
    for (unsigned byte = 0; byte < 256; ++byte) table[state][byte] = eat(state, byte);
  }
  return table;
}();

// Everything from the start of frame to the end of data, right aligned.
struct Message {
  Wide bits = 0;
  unsigned size = 0;  // number of bits, the dominant start bit included
};

// A message's bytes, the last one last, so that loops need no shifts of 128 bits.
using Bytes = std::array<std::uint8_t, sizeof(Wide)>;

Bytes bytes_of(Wide bits) {
  const std::array<std::uint64_t, 2> words = {__builtin_bswap64(static_cast<std::uint64_t>(bits >> 64)),
                                              __builtin_bswap64(static_cast<std::uint64_t>(bits))};
  return std::bit_cast<Bytes>(words);
}

Message message_of(const Frame& frame) {
  const unsigned length_code = std::min<unsigned>(frame.dlc, 8);
  const std::uint64_t request = frame.remote ? 1 : 0;
  Message message;
  if (frame.extended) {
    const std::uint64_t base = (frame.id >> 18) & 0x7FFu;
    // Base identifier, SRR and IDE recessive, identifier extension, RTR, two reserved bits, length code.
    message.bits = (base << 27) | (std::uint64_t{3} << 25) | (std::uint64_t{frame.id & 0x3FFFFu} << 7) |
                   (request << 6) | length_code;
    message.size = 39;
  } else {
    message.bits = (std::uint64_t{frame.id & 0x7FFu} << 7) | (request << 6) | length_code;
    message.size = 19;
  }
  if (!frame.remote) {
    const std::uint64_t data = __builtin_bswap64(std::bit_cast<std::uint64_t>(frame.data));
    if (length_code > 0) {
      message.bits = (message.bits << (8 * length_code)) | (data >> (64 - 8 * length_code));
    }
    message.size += 8 * length_code;
  }
  return message;
}

std::uint16_t crc_of(const Message& message) {
  // Leading zeros change nothing, so the message is taken in whole bytes from its end.
  const Bytes bytes = bytes_of(message.bits);
  const std::size_t count = (message.size + 7) / 8;
  unsigned crc = 0;
  for (std::size_t k = 0; k < count; ++k) crc ^= kCrc[k][bytes[bytes.size() - 1 - k]];
  return static_cast<std::uint16_t>(crc);
}

unsigned count_stuff_bits(const Message& message) {
  const unsigned size = message.size + kCrcBits;
  const Wide bits = (message.bits << kCrcBits) | crc_of(message);
  // Filled up in front to whole bytes with alternating levels that end recessive: none of them is stuffed,
  // and the dominant start of frame begins a new row.
  const unsigned fill = (8 - size % 8) % 8;
  const Bytes bytes = bytes_of((Wide{0x55u & ((1u << fill) - 1)} << size) | bits);
  unsigned state = state_of(1, 1);
  unsigned stuffed = 0;
  for (std::size_t i = bytes.size() - (size + fill) / 8; i < bytes.size(); ++i) {
    const Step step = kStuff[state][bytes[i]];
    state = step.state;
    stuffed += step.stuffed;
  }
  return stuffed;
}

}  // namespace

std::uint16_t crc15(const Frame& frame) noexcept {
  if (frame.error) return 0;
  return crc_of(message_of(frame));
}

unsigned stuff_bits(const Frame& frame) noexcept {
  if (frame.error) return 0;
  return count_stuff_bits(message_of(frame));
}

unsigned frame_bits(const Frame& frame) noexcept {
  if (frame.error) return kErrorFrameBits;
  const Message message = message_of(frame);
  return message.size + kCrcBits + count_stuff_bits(message) + kTailBits;
}

}  // namespace can
