#include "cansync/telegram/reply_payload.h"

namespace cansync {
namespace {

constexpr std::uint8_t kWordBytes = 2;
constexpr std::uint8_t kDoublewordBytes = 4;
constexpr std::uint8_t kSubSlaveBytes = 2;

/// The sub-slave address behind so many bytes, when it is there.
std::optional<SubSlave> sub_slave_behind(const ParameterReply& reply, std::uint8_t bytes) noexcept {
  if (reply.payload_size < bytes + kSubSlaveBytes) return std::nullopt;
  return SubSlave{load_word(reply.payload.data() + bytes)};
}

void append_word(ParameterReply& reply, std::uint16_t word) noexcept {
  store_word(reply.payload.data() + reply.payload_size, word);
  reply.payload_size = static_cast<std::uint8_t>(reply.payload_size + kWordBytes);
}

template <class Reply>
void begin(Reply& reply, bool busy, bool error) noexcept {
  reply.busy = busy;
  reply.error = error;
  reply.payload_size = 0;
  reply.payload = {};
}

}  // namespace

std::optional<ReadAnswer> read_answer(const ParameterReply& reply) noexcept {
  if (reply.payload_size < kWordBytes) return std::nullopt;
  const std::uint8_t* bytes = reply.payload.data();
  // Four bytes are a word and the address: a doubleword comes with it always.
  if (reply.payload_size == kDoublewordBytes + kSubSlaveBytes) {
    return ReadAnswer{load_doubleword(bytes), true, sub_slave_behind(reply, kDoublewordBytes)};
  }
  return ReadAnswer{load_word(bytes), false, sub_slave_behind(reply, kWordBytes)};
}

bool confirms_write(const ParameterReply& reply) noexcept {
  return reply.payload_size <= kSubSlaveBytes;
}

std::optional<SubSlave> write_sub_slave(const ParameterReply& reply) noexcept {
  return sub_slave_behind(reply, 0);
}

std::optional<ErrorAnswer> error_answer(const ParameterReply& reply) noexcept {
  if (reply.payload_size < kWordBytes) return std::nullopt;
  return ErrorAnswer{static_cast<ParameterError>(load_word(reply.payload.data())),
                     sub_slave_behind(reply, kWordBytes)};
}

std::optional<TransferError> error_answer(const TransferReply& reply) noexcept {
  if (reply.payload_size < kWordBytes) return std::nullopt;
  return static_cast<TransferError>(load_word(reply.payload.data()));
}

bool is_acknowledgement(const TransferReply& reply) noexcept {
  return reply.payload_size == 0;
}

std::optional<std::span<const std::uint8_t, kTransferBytes>> upload_bytes(
    const TransferReply& reply) noexcept {
  if (reply.payload_size != kTransferBytes) return std::nullopt;
  return std::span<const std::uint8_t, kTransferBytes>(reply.payload);
}

unsigned data_bytes(const ParameterReply& reply) noexcept {
  return 2u + reply.payload_size;
}
unsigned data_bytes(const TransferReply& reply) noexcept {
  return 2u + reply.payload_size;
}

void put_busy(ParameterReply& reply) noexcept {
  begin(reply, true, false);
}
void put_busy(TransferReply& reply) noexcept {
  begin(reply, true, false);
}

void put_error(ParameterReply& reply, ParameterError error, SubSlave sub_slave) noexcept {
  begin(reply, false, true);
  append_word(reply, static_cast<std::uint16_t>(error));
  append_word(reply, sub_slave.value);
}

void put_error(TransferReply& reply, TransferError error) noexcept {
  begin(reply, false, true);
  store_word(reply.payload.data(), static_cast<std::uint16_t>(error));
  reply.payload_size = kWordBytes;
}

void put_value(ParameterReply& reply, std::uint32_t value, bool doubleword, SubSlave sub_slave) noexcept {
  begin(reply, false, false);
  append_word(reply, static_cast<std::uint16_t>(value & 0xFFFF));
  if (doubleword) append_word(reply, static_cast<std::uint16_t>(value >> 16));
  append_word(reply, sub_slave.value);
}

void put_confirmation(ParameterReply& reply, SubSlave sub_slave) noexcept {
  begin(reply, false, false);
  append_word(reply, sub_slave.value);
}

void put_upload(TransferReply& reply, const std::array<std::uint8_t, kTransferBytes>& bytes) noexcept {
  begin(reply, false, false);
  reply.payload = bytes;
  reply.payload_size = kTransferBytes;
}

}  // namespace cansync
