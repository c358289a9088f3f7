#include "cansync/telegram/telegram.h"

#include <algorithm>
#include <memory>
#include <type_traits>

namespace cansync {
namespace {

using Kind = ParameterCommand::Kind;
using Direction = TransferInitialise::Direction;
using SixBytes = std::array<std::uint8_t, 6>;

// Bits of byte 0 on the command and response channels (M 3.2.1.3).
constexpr std::uint8_t kTransfer = 0x80;  // 1: upload or download, 0: parameter
constexpr std::uint8_t kDownload = 0x40;  // transfer command
constexpr std::uint8_t kModeMask = 0x30;  // transfer command
constexpr std::uint8_t kInitialise = 0x10;
constexpr std::uint8_t kBody = 0x20;
constexpr std::uint8_t kLast = 0x30;
constexpr unsigned kElementShift = 4;  // parameter command
constexpr unsigned kElementMask = 0x07;
constexpr std::uint8_t kBusy = 0x40;   // reply
constexpr std::uint8_t kError = 0x20;  // reply; bit 4 is free, whatever a slave writes there (M 3.2.1.3)

constexpr std::uint8_t kMaximumPayload = 6;

// --- the data bytes as one number, byte 0 lowest: a field of the tables is then a shift

constexpr std::uint64_t put(unsigned byte, std::uint64_t value) noexcept {
  return value << (8 * byte);
}

constexpr std::uint8_t byte_at(std::uint64_t data, unsigned byte) noexcept {
  return static_cast<std::uint8_t>(data >> (8 * byte));
}
constexpr std::uint16_t word_at(std::uint64_t data, unsigned byte) noexcept {
  return static_cast<std::uint16_t>(data >> (8 * byte));
}
constexpr std::uint32_t doubleword_at(std::uint64_t data, unsigned byte) noexcept {
  return static_cast<std::uint32_t>(data >> (8 * byte));
}

// Bytes 0 and 1 of commands and replies: four control bits, then twelve bits of a number, offset or length.
constexpr std::uint64_t put_control(unsigned control, unsigned twelve) noexcept {
  return put(0, control | (twelve >> 8)) | put(1, twelve & 0xFF);
}
constexpr std::uint16_t twelve_at_start(std::uint64_t data) noexcept {
  return static_cast<std::uint16_t>(((byte_at(data, 0) & 0x0Fu) << 8) | byte_at(data, 1));
}

// Six bytes from byte 2 on.
constexpr std::uint64_t put_six(const SixBytes& b) noexcept {
  return put(2, b[0]) | put(3, b[1]) | put(4, b[2]) | put(5, b[3]) | put(6, b[4]) | put(7, b[5]);
}
constexpr SixBytes six_of(std::uint64_t d) noexcept {
  return {byte_at(d, 2), byte_at(d, 3), byte_at(d, 4), byte_at(d, 5), byte_at(d, 6), byte_at(d, 7)};
}

// The first `dlc` bytes, 0..8; the others become zero.
constexpr std::uint64_t first_bytes(std::uint64_t data, unsigned dlc) noexcept {
  return dlc >= 8 ? data : data & (put(dlc, 1) - 1);
}

// Both written out: only so compilers make one move of it.
std::uint64_t data_of(const can::Frame& frame) noexcept {
  const auto& b = frame.data;
  const std::uint64_t data = put(0, b[0]) | put(1, b[1]) | put(2, b[2]) | put(3, b[3]) | put(4, b[4]) |
                             put(5, b[5]) | put(6, b[6]) | put(7, b[7]);
  return first_bytes(data, frame.dlc);
}

can::Frame frame_of(std::uint32_t identifier, unsigned dlc, std::uint64_t data) noexcept {
  const std::uint64_t d = first_bytes(data, dlc);
  return {.id = identifier,
          .dlc = static_cast<std::uint8_t>(dlc),
          .data = {byte_at(d, 0), byte_at(d, 1), byte_at(d, 2), byte_at(d, 3), byte_at(d, 4), byte_at(d, 5),
                   byte_at(d, 6), byte_at(d, 7)}};
}

// The masks keep each argument in range, so the optional is never empty.
SlaveNumber slave_of(const can::Frame& frame) noexcept {
  return *SlaveNumber::from(frame.id & 31u);
}
BlockOffset offset_of(std::uint64_t data) noexcept {
  return *BlockOffset::from(twelve_at_start(data));
}
ParameterNumber number_of(std::uint64_t data) noexcept {
  return *ParameterNumber::from(twelve_at_start(data));
}

// Decoders build the result anew where it stands: emplace and returning by value both copy it once more,
// which costs more than the decoding.
static_assert(std::is_trivially_destructible_v<Decoded>);

void fail(Decoded& result, DecodeError error) noexcept {
  std::construct_at(&result, std::in_place_index<1>, error);
}

template <class T>
T& begin(Decoded& result) noexcept {
  std::construct_at(&result, std::in_place_index<0>, std::in_place_type<T>);
  return *std::get_if<T>(std::get_if<0>(&result));
}

// --- action command

can::Frame encode(const ActionCommand& action) noexcept {
  return frame_of(identifier::action, 8,
                  put(0, action.slaves.bits) | put(4, action.command) | put(5, action.data_byte) |
                      put(6, action.data_word));
}

void decode_action(const can::Frame& frame, Decoded& result) noexcept {
  if (frame.dlc != 8) return fail(result, DecodeError::wrong_length);
  const std::uint64_t data = data_of(frame);
  if (byte_at(data, 4) == 0) return fail(result, DecodeError::reserved_bits);
  begin<ActionCommand>(result) = {
      {doubleword_at(data, 0)}, byte_at(data, 4), byte_at(data, 5), word_at(data, 6)};
}

// --- reference and actual values

std::uint64_t put_words(const std::array<std::uint16_t, 4>& word) noexcept {
  return put(0, word[0]) | put(2, word[1]) | put(4, word[2]) | put(6, word[3]);
}

template <class T>
void load_words(const can::Frame& frame, T& telegram) noexcept {
  const std::uint64_t data = data_of(frame);
  telegram.words = frame.dlc / 2;
  telegram.word = {word_at(data, 0), word_at(data, 2), word_at(data, 4), word_at(data, 6)};
}

unsigned dlc_of_words(std::uint8_t words) noexcept {
  return std::min<unsigned>(words, 4) * 2;
}

can::Frame encode(const ReferenceTelegram& telegram) noexcept {
  const std::uint32_t base =
      telegram.channel == Channel::one ? identifier::reference_one : identifier::reference_two;
  return frame_of(base | identifier::participant_of(telegram.polled), dlc_of_words(telegram.words),
                  put_words(telegram.word));
}

void decode_reference(const can::Frame& frame, Channel channel, Decoded& result) noexcept {
  if (frame.dlc % 2 != 0) return fail(result, DecodeError::wrong_length);
  auto& telegram = begin<ReferenceTelegram>(result);
  telegram.channel = channel;
  telegram.polled = static_cast<std::uint8_t>(identifier::participant_of(frame.id));
  load_words(frame, telegram);
}

can::Frame encode(const ActualTelegram& telegram) noexcept {
  const std::uint32_t base =
      telegram.channel == Channel::one ? identifier::actual_one : identifier::actual_two;
  return frame_of(base | telegram.slave.value(), dlc_of_words(telegram.words), put_words(telegram.word));
}

void decode_actual(const can::Frame& frame, Channel channel, Decoded& result) noexcept {
  if (frame.dlc % 2 != 0) return fail(result, DecodeError::wrong_length);
  auto& telegram = begin<ActualTelegram>(result);
  telegram.channel = channel;
  telegram.slave = slave_of(frame);
  load_words(frame, telegram);
}

// --- parameter command

can::Frame encode(const ParameterCommand& command) noexcept {
  const std::uint32_t id = identifier::command | command.slave.value();
  const std::uint64_t head =
      put_control(unsigned{command.element.value()} << kElementShift, command.number.value());
  const std::uint64_t sub_slave = command.sub_slave.value;
  switch (command.kind) {
    case Kind::read:
      return frame_of(id, 4, head | put(2, sub_slave));
    case Kind::write_word:
      return frame_of(id, 6, head | put(2, command.value & 0xFFFF) | put(4, sub_slave));
    default:
      return frame_of(id, 8, head | put(2, command.value) | put(6, sub_slave));
  }
}

void decode_parameter_command(const can::Frame& frame, std::uint64_t data, Decoded& result) noexcept {
  if (frame.dlc != 4 && frame.dlc != 6 && frame.dlc != 8) return fail(result, DecodeError::wrong_length);
  auto& command = begin<ParameterCommand>(result);
  command.slave = slave_of(frame);
  command.number = number_of(data);
  command.element = *Element::from((byte_at(data, 0) >> kElementShift) & kElementMask);
  command.sub_slave.value = word_at(data, frame.dlc - 2u);
  if (frame.dlc == 6) {
    command.kind = Kind::write_word;
    command.value = word_at(data, 2);
  } else if (frame.dlc == 8) {
    command.kind = Kind::write_doubleword;
    command.value = doubleword_at(data, 2);
  }
}

// --- upload and download commands

can::Frame encode(const TransferInitialise& initialise) noexcept {
  const unsigned direction = initialise.direction == Direction::download ? kDownload : 0;
  return frame_of(identifier::command | initialise.slave.value(), 8,
                  put_control(kTransfer | kInitialise | direction, initialise.length.value()) |
                      put(2, initialise.address) | put(6, initialise.sub_slave.value));
}

can::Frame encode(const UploadBlock& block) noexcept {
  return frame_of(identifier::command | block.slave.value(), 2,
                  put_control(kTransfer | (block.last ? kLast : kBody), block.offset.value()));
}

can::Frame encode(const DownloadBlock& block) noexcept {
  return frame_of(identifier::command | block.slave.value(), 8,
                  put_control(kTransfer | kDownload | (block.last ? kLast : kBody), block.offset.value()) |
                      put_six(block.data));
}

void decode_initialise(const can::Frame& frame, std::uint64_t data, Decoded& result) noexcept {
  if (frame.dlc != 8) return fail(result, DecodeError::wrong_length);
  const bool download = (byte_at(data, 0) & kDownload) != 0;
  begin<TransferInitialise>(result) = {slave_of(frame),
                                       download ? Direction::download : Direction::upload,
                                       offset_of(data),
                                       doubleword_at(data, 2),
                                       {word_at(data, 6)}};
}

void decode_block(const can::Frame& frame, std::uint64_t data, bool last, Decoded& result) noexcept {
  if ((byte_at(data, 0) & kDownload) == 0) {
    if (frame.dlc != 2) return fail(result, DecodeError::wrong_length);
    begin<UploadBlock>(result) = {slave_of(frame), offset_of(data), last};
    return;
  }
  if (frame.dlc != 8) return fail(result, DecodeError::wrong_length);
  begin<DownloadBlock>(result) = {slave_of(frame), offset_of(data), last, six_of(data)};
}

void decode_command(const can::Frame& frame, Decoded& result) noexcept {
  if (frame.dlc < 2) return fail(result, DecodeError::wrong_length);  // bytes 0 and 1 are read below
  const std::uint64_t data = data_of(frame);
  if ((byte_at(data, 0) & kTransfer) == 0) return decode_parameter_command(frame, data, result);
  switch (byte_at(data, 0) & kModeMask) {
    case kInitialise:
      return decode_initialise(frame, data, result);
    case kBody:
      return decode_block(frame, data, false, result);
    case kLast:
      return decode_block(frame, data, true, result);
    default:
      return fail(result, DecodeError::reserved_bits);
  }
}

// --- replies

template <class Reply>
can::Frame encode_reply(const Reply& reply, unsigned kind, unsigned twelve) noexcept {
  const unsigned size = std::min(reply.payload_size, kMaximumPayload);
  const unsigned control = kind | (reply.busy ? kBusy : 0u) | (reply.error ? kError : 0u);
  return frame_of(identifier::response | reply.slave.value(), size + 2,
                  put_control(control, twelve) | put_six(reply.payload));
}

can::Frame encode(const ParameterReply& reply) noexcept {
  return encode_reply(reply, 0, reply.number.value());
}

can::Frame encode(const TransferReply& reply) noexcept {
  return encode_reply(reply, kTransfer, reply.offset.value());
}

// While busy the length is open in the manuals; any that holds the number is taken.
bool length_fits(std::uint8_t control, std::uint8_t dlc) noexcept {
  if ((control & kBusy) != 0) return true;
  const bool error = (control & kError) != 0;
  if ((control & kTransfer) == 0) return error ? dlc == 4 || dlc == 6 : dlc % 2 == 0;
  return error ? dlc == 4 : dlc == 2 || dlc == 8;
}

template <class Reply>
void load_reply(const can::Frame& frame, std::uint64_t data, Reply& reply) noexcept {
  reply.slave = slave_of(frame);
  reply.busy = (byte_at(data, 0) & kBusy) != 0;
  reply.error = (byte_at(data, 0) & kError) != 0;
  reply.payload_size = static_cast<std::uint8_t>(frame.dlc - 2);
  reply.payload = six_of(data);
}

void decode_reply(const can::Frame& frame, Decoded& result) noexcept {
  if (frame.dlc < 2) return fail(result, DecodeError::wrong_length);
  const std::uint64_t data = data_of(frame);
  const std::uint8_t control = byte_at(data, 0);
  if (!length_fits(control, frame.dlc)) return fail(result, DecodeError::wrong_length);
  if ((control & kTransfer) == 0) {
    auto& reply = begin<ParameterReply>(result);
    reply.number = number_of(data);
    load_reply(frame, data, reply);
    return;
  }
  auto& reply = begin<TransferReply>(result);
  reply.offset = offset_of(data);
  load_reply(frame, data, reply);
}

constexpr bool is_cansync(std::uint32_t id) noexcept {
  // 0x100..0x1FF, 0x300..0x3FF and 0x500..0x5FF: bits 10..8 are 001, 011 or 101.
  const std::uint32_t block = id >> 8;
  return id == identifier::action || block == 1 || block == 3 || block == 5;
}

DecodeError error_of(const can::Frame& frame) noexcept {
  if (frame.error) return DecodeError::error_frame;
  return frame.remote ? DecodeError::remote : DecodeError::extended;
}

void decode_into(const can::Frame& frame, Decoded& result) noexcept {
  if (!is_cansync(frame.id)) return fail(result, DecodeError::not_for_us);
  if (!frame.is_standard_data()) return fail(result, error_of(frame));
  if (frame.dlc > 8) return fail(result, DecodeError::wrong_length);
  const std::uint32_t channel = identifier::channel_of(frame.id);
  switch (channel) {
    case identifier::reference_one:
      return decode_reference(frame, Channel::one, result);
    case identifier::reference_two:
      return decode_reference(frame, Channel::two, result);
    case 0:  // is_cansync lets the action command alone through
      return decode_action(frame, result);
    default:
      break;
  }
  if (identifier::participant_of(frame.id) > SlaveNumber::max) return fail(result, DecodeError::wrong_slave);
  switch (channel) {
    case identifier::actual_one:
      return decode_actual(frame, Channel::one, result);
    case identifier::actual_two:
      return decode_actual(frame, Channel::two, result);
    case identifier::command:
      return decode_command(frame, result);
    default:
      return decode_reply(frame, result);
  }
}

}  // namespace

// A switch over the index: cheaper than std::visit's table of function pointers.
can::Frame encode(const Telegram& telegram) noexcept {
  switch (telegram.index()) {
    case 0:
      return encode(*std::get_if<0>(&telegram));
    case 1:
      return encode(*std::get_if<1>(&telegram));
    case 2:
      return encode(*std::get_if<2>(&telegram));
    case 3:
      return encode(*std::get_if<3>(&telegram));
    case 4:
      return encode(*std::get_if<4>(&telegram));
    case 5:
      return encode(*std::get_if<5>(&telegram));
    case 6:
      return encode(*std::get_if<6>(&telegram));
    case 7:
      return encode(*std::get_if<7>(&telegram));
    default:
      return encode(*std::get_if<8>(&telegram));
  }
}
static_assert(std::variant_size_v<Telegram> == 9, "encode needs a case for every telegram");

Decoded decode(const can::Frame& frame) noexcept {
  Decoded result(std::in_place_index<1>, DecodeError::not_for_us);  // every path builds it anew
  decode_into(frame, result);
  return result;
}

}  // namespace cansync
