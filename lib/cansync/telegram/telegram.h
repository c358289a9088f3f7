#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <variant>

#include "can/frame.h"
#include "cansync/telegram/numbers.h"

/// Every CANsync telegram as a struct, and the two functions between structs and frames (M 3.2.1).
/// Pure functions; safe on the realtime thread.
namespace cansync {

/// Identifiers by channel; the slave number N stands in the lower seven bits.
namespace identifier {
inline constexpr std::uint32_t action = 0x010;
inline constexpr std::uint32_t reference_one = 0x100;
inline constexpr std::uint32_t reference_two = 0x180;
inline constexpr std::uint32_t actual_one = 0x300;
inline constexpr std::uint32_t actual_two = 0x380;
inline constexpr std::uint32_t command = 0x500;
inline constexpr std::uint32_t response = 0x580;

/// The bits that are a slave number, or what stands for none; and those that are the channel.
inline constexpr std::uint32_t number_bits = 0x7F;
inline constexpr std::uint32_t channel_bits = 0x7FF & ~number_bits;

/// The channel of an identifier: one of those above, if it is of CANsync. Bits over the eleven of a CANsync
/// identifier stay.
constexpr std::uint32_t channel_of(std::uint32_t identifier) noexcept {
  return identifier & ~number_bits;
}
/// N of an identifier, 0..127; the action command has none.
constexpr std::uint32_t participant_of(std::uint32_t identifier) noexcept {
  return identifier & number_bits;
}
}  // namespace identifier

/// Command 1 of an action command: the data word is a control word.
inline constexpr std::uint8_t kCommandControlWord = 1;
/// `N` of a reference value telegram that asks no slave (open in the manuals; settable).
inline constexpr std::uint8_t kPollNobody = 127;

/// Action command (0x010): to every slave whose mask bit is set; never answered.
struct ActionCommand {
  SlaveMask slaves;
  std::uint8_t command =
      0;  ///< 1 control word, 2..127 reserved, 128..255 free for the user; 0 is not allowed
  std::uint8_t data_byte = 0;   ///< 0..255, the command's own
  std::uint16_t data_word = 0;  ///< 0..65535; command 1: the control word
  friend bool operator==(const ActionCommand&, const ActionCommand&) = default;
};

/// WRC1 or WRC2: up to four reference value words to all slaves.
struct ReferenceTelegram {
  Channel channel = Channel::one;
  std::uint8_t polled =
      kPollNobody;         ///< N, 0..127: the slave that must answer in this interval; over 31 nobody
  std::uint8_t words = 4;  ///< number of words, 0..4
  std::array<std::uint16_t, 4> word = {};  ///< word n in bytes 2n and 2n + 1, low byte first
  friend bool operator==(const ReferenceTelegram&, const ReferenceTelegram&) = default;
};

/// RDC1 or RDC2: up to four actual value words of one slave.
struct ActualTelegram {
  Channel channel = Channel::one;
  SlaveNumber slave;
  std::uint8_t words = 4;                  ///< number of words, 0..4
  std::array<std::uint16_t, 4> word = {};  ///< word n in bytes 2n and 2n + 1, low byte first
  friend bool operator==(const ActualTelegram&, const ActualTelegram&) = default;
};

/// Parameter command: the length alone tells read from write, and word from doubleword.
struct ParameterCommand {
  /// What is asked; DLC 4, 6, 8 on the bus.
  enum class Kind : std::uint8_t { read, write_word, write_doubleword };
  SlaveNumber slave;
  Kind kind = Kind::read;
  ParameterNumber number;
  Element element = kValueElement;
  std::uint32_t value = 0;  ///< write_word: 0..0xFFFF; read: 0
  SubSlave sub_slave;
  friend bool operator==(const ParameterCommand&, const ParameterCommand&) = default;
};

/// Initialises an upload or download; length 0 with address 0 as an upload cancels.
struct TransferInitialise {
  /// Bit 6 of the first byte.
  enum class Direction : std::uint8_t { upload, download };  ///< upload: slave to master
  SlaveNumber slave;
  Direction direction = Direction::upload;
  BlockOffset length;         ///< bytes of this block
  std::uint32_t address = 0;  ///< start address; 0x00..0xFF belong to the slave's operating system
  SubSlave sub_slave;
  friend bool operator==(const TransferInitialise&, const TransferInitialise&) = default;
};

/// The telegram that cancels a running transfer on a slave.
constexpr TransferInitialise cancel_transfer(SlaveNumber slave) noexcept {
  return {slave, TransferInitialise::Direction::upload, {}, 0, {}};
}

/// Asks for the 6 bytes at `offset` of a running upload.
struct UploadBlock {
  SlaveNumber slave;
  BlockOffset offset;  ///< bytes from 0 in steps of 6
  bool last = false;
  friend bool operator==(const UploadBlock&, const UploadBlock&) = default;
};

/// Brings the 6 bytes at `offset` of a running download; in the last one the slave takes only what is due.
struct DownloadBlock {
  SlaveNumber slave;
  BlockOffset offset;
  bool last = false;
  std::array<std::uint8_t, 6> data = {};  ///< bytes 2..7 of the telegram
  friend bool operator==(const DownloadBlock&, const DownloadBlock&) = default;
};

/// Answer to a parameter command. What the payload means depends on the command that was asked; see
/// `reply_payload.h`. DLC is 2 + `payload_size`.
struct ParameterReply {
  SlaveNumber slave;
  ParameterNumber number;
  bool busy = false;
  bool error = false;
  std::uint8_t payload_size = 0;             ///< 0, 2, 4 or 6 bytes; while busy 0..6
  std::array<std::uint8_t, 6> payload = {};  ///< bytes 2..7 of the telegram
  friend bool operator==(const ParameterReply&, const ParameterReply&) = default;
};

/// Answer to an upload or download telegram; for the payload see `reply_payload.h`. DLC is 2 +
/// `payload_size`.
struct TransferReply {
  SlaveNumber slave;
  BlockOffset offset;  ///< offset of the block, or the length after an initialise
  bool busy = false;
  bool error = false;
  std::uint8_t payload_size = 0;             ///< 0 acknowledged, 6 upload data, 2 error code; while busy 0..6
  std::array<std::uint8_t, 6> payload = {};  ///< bytes 2..7 of the telegram
  friend bool operator==(const TransferReply&, const TransferReply&) = default;
};

using Telegram = std::variant<ActionCommand, ReferenceTelegram, ActualTelegram, ParameterCommand,
                              TransferInitialise, UploadBlock, DownloadBlock, ParameterReply, TransferReply>;

/// Why a frame is no CANsync telegram.
enum class DecodeError : std::uint8_t {
  not_for_us,     ///< identifier outside the CANsync channels
  extended,       ///< extended data frame with the number of a CANsync identifier
  remote,         ///< remote frame, of either format, with the number of a CANsync identifier
  error_frame,    ///< error frame with the number of a CANsync identifier
  wrong_slave,    ///< N is over 31 where a slave number must stand
  wrong_length,   ///< DLC not allowed for this telegram
  reserved_bits,  ///< a reserved bit or code is used
};
inline constexpr unsigned kDecodeErrors = 7;

/// One short English word group for a decode error, for logs and counters.
std::string_view name(DecodeError error) noexcept;

using Decoded = std::variant<Telegram, DecodeError>;

/// The telegram's frame. Fields are in range by their types; `words` over 4 counts as 4.
can::Frame encode(const Telegram& telegram) noexcept;

/// The telegram in a frame, or why there is none.
Decoded decode(const can::Frame& frame) noexcept;

/// Little-endian helpers for payloads, the only ones in the project.
constexpr std::uint16_t load_word(const std::uint8_t* bytes) noexcept {
  return static_cast<std::uint16_t>(bytes[0] | (bytes[1] << 8));
}
/// The 32-bit number in `bytes[0..3]`, the lowest first.
constexpr std::uint32_t load_doubleword(const std::uint8_t* bytes) noexcept {
  return load_word(bytes) | (static_cast<std::uint32_t>(load_word(bytes + 2)) << 16);
}
/// Writes `value` to `bytes[0..1]`, the low byte first.
constexpr void store_word(std::uint8_t* bytes, std::uint16_t value) noexcept {
  bytes[0] = static_cast<std::uint8_t>(value & 0xFF);
  bytes[1] = static_cast<std::uint8_t>(value >> 8);
}
/// Writes `value` to `bytes[0..3]`, the lowest byte first.
constexpr void store_doubleword(std::uint8_t* bytes, std::uint32_t value) noexcept {
  store_word(bytes, static_cast<std::uint16_t>(value & 0xFFFF));
  store_word(bytes + 2, static_cast<std::uint16_t>(value >> 16));
}

}  // namespace cansync
