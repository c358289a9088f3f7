#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "cansync/telegram/errors.h"
#include "cansync/telegram/numbers.h"
#include "cansync/telegram/telegram.h"

/// What stands where in bytes 2 to 7 of a reply (M 3.2.1.3): nobody else looks at them. The command that was
/// asked tells which of these answers it is; a busy reply has none. Pure; realtime safe.
namespace cansync {

/// Answer to a parameter read: the value, and behind it the sub-slave address.
struct ReadAnswer {
  std::uint32_t value = 0;            ///< a word: 0..0xFFFF
  bool doubleword = false;            ///< as it was sent
  std::optional<SubSlave> sub_slave;  ///< nothing: a word whose sub-slave address is left out
};
/// Nothing: the reply has no value.
std::optional<ReadAnswer> read_answer(const ParameterReply& reply) noexcept;

/// True for what may confirm a write: a sub-slave address or nothing at all.
bool confirms_write(const ParameterReply& reply) noexcept;
/// The sub-slave address of the answer to a write; nothing when it is left out.
std::optional<SubSlave> write_sub_slave(const ParameterReply& reply) noexcept;

/// Answer that refuses a parameter command.
struct ErrorAnswer {
  ParameterError error = ParameterError::none;  ///< may be a code without a name
  std::optional<SubSlave> sub_slave;            ///< nothing: left out
};
/// What a reply with `error` says; nothing when there is no code in it.
std::optional<ErrorAnswer> error_answer(const ParameterReply& reply) noexcept;
std::optional<TransferError> error_answer(const TransferReply& reply) noexcept;

/// Bytes that one upload or download telegram carries; in the last one those over are padding.
inline constexpr std::uint16_t kTransferBytes = 6;

/// True for a reply that only says that the telegram was taken.
bool is_acknowledgement(const TransferReply& reply) noexcept;
/// The bytes that an upload brought; nothing when there are none. They are the reply's own.
std::optional<std::span<const std::uint8_t, kTransferBytes>> upload_bytes(
    const TransferReply& reply) noexcept;

/// Data bytes of the reply's frame, 2..8.
unsigned data_bytes(const ParameterReply& reply) noexcept;
unsigned data_bytes(const TransferReply& reply) noexcept;

// --- a slave's side; each sets what the reply says, and leaves who says it of what

/// Not ready: the same telegram is to be sent again.
void put_busy(ParameterReply& reply) noexcept;
void put_busy(TransferReply& reply) noexcept;
/// The command is refused.
void put_error(ParameterReply& reply, ParameterError error, SubSlave sub_slave) noexcept;
void put_error(TransferReply& reply, TransferError error) noexcept;
/// The value that was read; of a word the lower 16 bits.
void put_value(ParameterReply& reply, std::uint32_t value, bool doubleword, SubSlave sub_slave) noexcept;
/// The value was written.
void put_confirmation(ParameterReply& reply, SubSlave sub_slave) noexcept;
/// The bytes that were asked for.
void put_upload(TransferReply& reply, const std::array<std::uint8_t, kTransferBytes>& bytes) noexcept;

}  // namespace cansync
