#include "cansync/telegram.h"

#include <algorithm>

namespace cansync {
namespace {

using Bytes = std::array<std::uint8_t, 8>;
using Kind = ParameterCommand::Kind;
using Direction = TransferInitialise::Direction;

// Bits of byte 0 on the command and response channels (M 3.2.1.3).
constexpr std::uint8_t kTransfer = 0x80;  // 1: upload or download, 0: parameter
constexpr std::uint8_t kDownload = 0x40;  // transfer command
constexpr std::uint8_t kModeMask = 0x30;  // transfer command
constexpr std::uint8_t kInitialise = 0x10;
constexpr std::uint8_t kBody = 0x20;
constexpr std::uint8_t kLast = 0x30;
constexpr unsigned kElementShift = 4;  // parameter command
constexpr std::uint8_t kElementMask = 0x07;
constexpr std::uint8_t kBusy = 0x40;      // reply
constexpr std::uint8_t kError = 0x20;     // reply
constexpr std::uint8_t kReserved = 0x10;  // reply
constexpr std::uint8_t kHighMask = 0x0F;  // bits 11..8 of a parameter number, offset or length

constexpr std::uint32_t kSlaveNumberMask = 0x7F;
constexpr std::uint8_t kMaximumPayload = 6;

can::Frame frame_of(std::uint32_t identifier, std::uint8_t dlc) noexcept {
  can::Frame frame;
  frame.id = identifier;
  frame.dlc = dlc;
  return frame;
}

// Twelve bits in bytes 0 (low nibble) and 1; `control` gives the upper nibble of byte 0.
void store_twelve(Bytes& bytes, std::uint8_t control, std::uint16_t value) noexcept {
  bytes[0] = static_cast<std::uint8_t>(control | (value >> 8));
  bytes[1] = static_cast<std::uint8_t>(value & 0xFF);
}

std::uint16_t load_twelve(const Bytes& bytes) noexcept {
  return static_cast<std::uint16_t>(((bytes[0] & kHighMask) << 8) | bytes[1]);
}

// The masks keep each argument in range, so the optional is never empty.
SlaveNumber slave_of(std::uint32_t identifier) noexcept {
  return *SlaveNumber::from(identifier & 31u);
}
BlockOffset offset_of(const Bytes& bytes) noexcept {
  return *BlockOffset::from(load_twelve(bytes));
}
ParameterNumber number_of(const Bytes& bytes) noexcept {
  return *ParameterNumber::from(load_twelve(bytes));
}

template <class T>
Decoded done(const T& telegram) noexcept {
  return Decoded(std::in_place_index<0>, telegram);
}

Decoded failed(DecodeError error) noexcept {
  return Decoded(std::in_place_index<1>, error);
}

// --- action command

can::Frame encode(const ActionCommand& action) noexcept {
  can::Frame frame = frame_of(identifier::action, 8);
  store_doubleword(&frame.data[0], action.slaves.bits);
  frame.data[4] = action.command;
  frame.data[5] = action.data_byte;
  store_word(&frame.data[6], action.data_word);
  return frame;
}

Decoded decode_action(const can::Frame& frame) noexcept {
  if (frame.dlc != 8) return failed(DecodeError::wrong_length);
  if (frame.data[4] == 0) return failed(DecodeError::reserved_bits);
  return done(ActionCommand{
      {load_doubleword(&frame.data[0])}, frame.data[4], frame.data[5], load_word(&frame.data[6])});
}

// --- reference and actual values

void store_words(can::Frame& frame, const std::array<std::uint16_t, 4>& word) noexcept {
  for (unsigned i = 0; i * 2u < frame.dlc; ++i) store_word(&frame.data[i * 2u], word[i]);
}

template <class T>
void load_words(const can::Frame& frame, T& telegram) noexcept {
  telegram.words = frame.dlc / 2;
  for (unsigned i = 0; i < telegram.words; ++i) telegram.word[i] = load_word(&frame.data[i * 2u]);
}

std::uint8_t dlc_of_words(std::uint8_t words) noexcept {
  return static_cast<std::uint8_t>(std::min<std::uint8_t>(words, 4) * 2);
}

can::Frame encode(const ReferenceTelegram& telegram) noexcept {
  const std::uint32_t base =
      telegram.channel == Channel::one ? identifier::reference_one : identifier::reference_two;
  can::Frame frame = frame_of(base | (telegram.polled & kSlaveNumberMask), dlc_of_words(telegram.words));
  store_words(frame, telegram.word);
  return frame;
}

Decoded decode_reference(const can::Frame& frame, Channel channel) noexcept {
  if (frame.dlc % 2 != 0) return failed(DecodeError::wrong_length);
  ReferenceTelegram telegram;
  telegram.channel = channel;
  telegram.polled = static_cast<std::uint8_t>(frame.id & kSlaveNumberMask);
  load_words(frame, telegram);
  return done(telegram);
}

can::Frame encode(const ActualTelegram& telegram) noexcept {
  const std::uint32_t base =
      telegram.channel == Channel::one ? identifier::actual_one : identifier::actual_two;
  can::Frame frame = frame_of(base | telegram.slave.value(), dlc_of_words(telegram.words));
  store_words(frame, telegram.word);
  return frame;
}

Decoded decode_actual(const can::Frame& frame, Channel channel) noexcept {
  if (frame.dlc % 2 != 0) return failed(DecodeError::wrong_length);
  ActualTelegram telegram;
  telegram.channel = channel;
  telegram.slave = slave_of(frame.id);
  load_words(frame, telegram);
  return done(telegram);
}

// --- parameter command

can::Frame encode(const ParameterCommand& command) noexcept {
  static constexpr std::array<std::uint8_t, 3> kDlc = {4, 6, 8};  // by Kind
  can::Frame frame =
      frame_of(identifier::command | command.slave.value(), kDlc[static_cast<unsigned>(command.kind)]);
  store_twelve(frame.data, static_cast<std::uint8_t>(command.element.value() << kElementShift),
               command.number.value());
  if (command.kind == Kind::write_word) {
    store_word(&frame.data[2], static_cast<std::uint16_t>(command.value & 0xFFFF));
  } else if (command.kind == Kind::write_doubleword) {
    store_doubleword(&frame.data[2], command.value);
  }
  store_word(&frame.data[frame.dlc - 2u], command.sub_slave.value);
  return frame;
}

Decoded decode_parameter_command(const can::Frame& frame) noexcept {
  ParameterCommand command;
  switch (frame.dlc) {
    case 4:
      break;
    case 6:
      command.kind = Kind::write_word;
      command.value = load_word(&frame.data[2]);
      break;
    case 8:
      command.kind = Kind::write_doubleword;
      command.value = load_doubleword(&frame.data[2]);
      break;
    default:
      return failed(DecodeError::wrong_length);
  }
  command.slave = slave_of(frame.id);
  command.number = number_of(frame.data);
  command.element =
      *Element::from(static_cast<std::uint64_t>((frame.data[0] >> kElementShift) & kElementMask));
  command.sub_slave.value = load_word(&frame.data[frame.dlc - 2u]);
  return done(command);
}

// --- upload and download commands

can::Frame encode(const TransferInitialise& initialise) noexcept {
  can::Frame frame = frame_of(identifier::command | initialise.slave.value(), 8);
  const std::uint8_t direction = initialise.direction == Direction::download ? kDownload : 0;
  store_twelve(frame.data, kTransfer | kInitialise | direction, initialise.length.value());
  store_doubleword(&frame.data[2], initialise.address);
  store_word(&frame.data[6], initialise.sub_slave.value);
  return frame;
}

can::Frame encode(const UploadBlock& block) noexcept {
  can::Frame frame = frame_of(identifier::command | block.slave.value(), 2);
  store_twelve(frame.data, kTransfer | (block.last ? kLast : kBody), block.offset.value());
  return frame;
}

can::Frame encode(const DownloadBlock& block) noexcept {
  can::Frame frame = frame_of(identifier::command | block.slave.value(), 8);
  store_twelve(frame.data, kTransfer | kDownload | (block.last ? kLast : kBody), block.offset.value());
  std::copy(block.data.begin(), block.data.end(), frame.data.begin() + 2);
  return frame;
}

Decoded decode_initialise(const can::Frame& frame) noexcept {
  if (frame.dlc != 8) return failed(DecodeError::wrong_length);
  return done(TransferInitialise{slave_of(frame.id),
                                 (frame.data[0] & kDownload) != 0 ? Direction::download : Direction::upload,
                                 offset_of(frame.data),
                                 load_doubleword(&frame.data[2]),
                                 {load_word(&frame.data[6])}});
}

Decoded decode_block(const can::Frame& frame, bool last) noexcept {
  if ((frame.data[0] & kDownload) == 0) {
    if (frame.dlc != 2) return failed(DecodeError::wrong_length);
    return done(UploadBlock{slave_of(frame.id), offset_of(frame.data), last});
  }
  if (frame.dlc != 8) return failed(DecodeError::wrong_length);
  DownloadBlock block{slave_of(frame.id), offset_of(frame.data), last, {}};
  std::copy(frame.data.begin() + 2, frame.data.end(), block.data.begin());
  return done(block);
}

Decoded decode_command(const can::Frame& frame) noexcept {
  if (frame.dlc < 2) return failed(DecodeError::wrong_length);  // bytes 0 and 1 are read below
  if ((frame.data[0] & kTransfer) == 0) return decode_parameter_command(frame);
  switch (frame.data[0] & kModeMask) {
    case kInitialise:
      return decode_initialise(frame);
    case kBody:
      return decode_block(frame, false);
    case kLast:
      return decode_block(frame, true);
    default:
      return failed(DecodeError::reserved_bits);
  }
}

// --- replies

template <class Reply>
can::Frame encode_reply(const Reply& reply, std::uint8_t kind, std::uint16_t twelve) noexcept {
  const std::uint8_t size = std::min(reply.payload_size, kMaximumPayload);
  can::Frame frame =
      frame_of(identifier::response | reply.slave.value(), static_cast<std::uint8_t>(size + 2));
  const std::uint8_t busy = reply.busy ? kBusy : 0;
  const std::uint8_t error = reply.error ? kError : 0;
  store_twelve(frame.data, static_cast<std::uint8_t>(kind | busy | error), twelve);
  for (unsigned i = 0; i < size; ++i) frame.data[i + 2u] = reply.payload[i];
  return frame;
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
void load_reply(const can::Frame& frame, Reply& reply) noexcept {
  reply.slave = slave_of(frame.id);
  reply.busy = (frame.data[0] & kBusy) != 0;
  reply.error = (frame.data[0] & kError) != 0;
  reply.payload_size = static_cast<std::uint8_t>(frame.dlc - 2);
  for (unsigned i = 0; i < reply.payload_size; ++i) reply.payload[i] = frame.data[i + 2u];
}

Decoded decode_reply(const can::Frame& frame) noexcept {
  if (frame.dlc < 2) return failed(DecodeError::wrong_length);
  const std::uint8_t control = frame.data[0];
  if ((control & kReserved) != 0) return failed(DecodeError::reserved_bits);
  if (!length_fits(control, frame.dlc)) return failed(DecodeError::wrong_length);
  if ((control & kTransfer) == 0) {
    ParameterReply reply;
    reply.number = number_of(frame.data);
    load_reply(frame, reply);
    return done(reply);
  }
  TransferReply reply;
  reply.offset = offset_of(frame.data);
  load_reply(frame, reply);
  return done(reply);
}

constexpr bool is_cansync(std::uint32_t identifier) noexcept {
  // 0x100..0x1FF, 0x300..0x3FF and 0x500..0x5FF: bits 10..8 are 001, 011 or 101.
  const std::uint32_t block = identifier >> 8;
  return identifier == identifier::action || block == 1 || block == 3 || block == 5;
}

}  // namespace

// A switch over the index: measurably cheaper than std::visit's table of function pointers.
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
  if (!is_cansync(frame.id)) return failed(DecodeError::not_for_us);
  if (frame.kind != can::FrameKind::standard) return failed(DecodeError::not_standard);
  if (frame.dlc > 8) return failed(DecodeError::wrong_length);
  const std::uint32_t channel = frame.id & ~kSlaveNumberMask;
  switch (channel) {
    case identifier::reference_one:
      return decode_reference(frame, Channel::one);
    case identifier::reference_two:
      return decode_reference(frame, Channel::two);
    case 0:  // is_cansync lets the action command alone through
      return decode_action(frame);
    default:
      break;
  }
  if ((frame.id & kSlaveNumberMask) > SlaveNumber::max) return failed(DecodeError::wrong_slave);
  switch (channel) {
    case identifier::actual_one:
      return decode_actual(frame, Channel::one);
    case identifier::actual_two:
      return decode_actual(frame, Channel::two);
    case identifier::command:
      return decode_command(frame);
    default:
      return decode_reply(frame);
  }
}

}  // namespace cansync
