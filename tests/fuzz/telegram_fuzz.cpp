// Frames to telegrams and back, and telegrams to frames and back (lib/cansync/telegram/telegram.h).
#include "bytes.h"
#include "cansync/telegram/telegram.h"
#include "frames.h"
#include "require.h"

namespace {

using namespace cansync;
using fuzz::Bytes;
using fuzz::require;

std::array<std::uint16_t, 4> words(Bytes& in) {
  return {in.number<std::uint16_t>(), in.number<std::uint16_t>(), in.number<std::uint16_t>(),
          in.number<std::uint16_t>()};
}
std::array<std::uint8_t, 6> six(Bytes& in) {
  std::array<std::uint8_t, 6> out{};
  for (std::uint8_t& byte : out) byte = in.byte();
  return out;
}
SlaveNumber slave(Bytes& in) {
  return *SlaveNumber::from(in.below(kSlaves));
}
BlockOffset offset(Bytes& in) {
  return *BlockOffset::from(in.below(4096));
}
ParameterNumber parameter(Bytes& in) {
  return *ParameterNumber::from(in.below(4096));
}

ParameterCommand parameter_command(Bytes& in) {
  ParameterCommand command;
  command.slave = slave(in);
  command.kind = static_cast<ParameterCommand::Kind>(in.below(3));
  command.number = parameter(in);
  command.element = *Element::from(in.below(8));
  command.value = in.number<std::uint32_t>();
  command.sub_slave.value = in.number<std::uint16_t>();
  return command;
}

/// Any telegram that the types allow, whether or not it can stand on the bus.
Telegram telegram(Bytes& in) {
  const auto direction = [&] { return static_cast<TransferInitialise::Direction>(in.below(2)); };
  const auto channel = [&] { return static_cast<Channel>(in.below(2)); };
  switch (in.below(9)) {
    case 0:
      return ActionCommand{{in.number<std::uint32_t>()}, in.byte(), in.byte(), in.number<std::uint16_t>()};
    case 1:
      return ReferenceTelegram{channel(), in.byte(), in.byte(), words(in)};
    case 2:
      return ActualTelegram{channel(), slave(in), in.byte(), words(in)};
    case 3:
      return parameter_command(in);
    case 4:
      return TransferInitialise{
          slave(in), direction(), offset(in), in.number<std::uint32_t>(), {in.number<std::uint16_t>()}};
    case 5:
      return UploadBlock{slave(in), offset(in), in.flag()};
    case 6:
      return DownloadBlock{slave(in), offset(in), in.flag(), six(in)};
    case 7:
      return ParameterReply{slave(in), parameter(in), in.flag(), in.flag(), in.byte(), six(in)};
    default:
      return TransferReply{slave(in), offset(in), in.flag(), in.flag(), in.byte(), six(in)};
  }
}

void check_frame(const can::Frame& frame) {
  const Decoded decoded = decode(frame);
  const auto* understood = std::get_if<Telegram>(&decoded);
  if (understood == nullptr) {
    require(static_cast<unsigned>(std::get<DecodeError>(decoded)) < kDecodeErrors, "the error has a name");
    return;
  }
  can::Frame expected = frame;
  const bool reply = std::holds_alternative<ParameterReply>(*understood) ||
                     std::holds_alternative<TransferReply>(*understood);
  if (reply) expected.data[0] &= 0xEF;  // its free bit is not looked at
  for (std::size_t i = frame.dlc; i < frame.data.size(); ++i) expected.data[i] = 0;
  require(encode(*understood) == expected, "a telegram encodes to the frame it was decoded from");
}

void check_telegram(const Telegram& given) {
  const can::Frame frame = encode(given);
  require(frame.is_standard_data() && frame.id <= 0x7FF && frame.dlc <= 8,
          "every telegram is a standard data frame");
  for (std::size_t i = frame.dlc; i < frame.data.size(); ++i)
    require(frame.data[i] == 0, "bytes behind the length are zero");
  const Decoded decoded = decode(frame);
  if (const auto* again = std::get_if<Telegram>(&decoded)) {
    require(again->index() == given.index(), "a telegram decodes as what it was");
    require(encode(*again) == frame, "a decoded telegram encodes to the same frame");
    return;
  }
  const DecodeError error = std::get<DecodeError>(decoded);
  require(error == DecodeError::wrong_length || error == DecodeError::reserved_bits,
          "no type of telegram leaves its channel");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes in(data, size);
  while (!in.empty()) {
    if (in.flag()) {
      check_telegram(telegram(in));
    } else {
      check_frame(fuzz::frame(in));
    }
  }
  return 0;
}
