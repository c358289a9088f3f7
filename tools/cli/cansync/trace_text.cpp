#include "cli/cansync/trace_text.h"

#include <fmt/compile.h>
#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <span>
#include <type_traits>
#include <vector>

#include "cansync/telegram/errors.h"
#include "cansync/telegram/reply_payload.h"
#include "cli/text/values.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

using Bytes = std::span<const std::uint8_t>;

// Of the columns of `trace`.
constexpr std::size_t kTimeWidth = 17;
constexpr std::size_t kSinceWidth = 8;
constexpr std::size_t kChannelWidth = 7;
constexpr std::size_t kSlaveWidth = 5;

void add_right(std::string& line, std::string_view text, std::size_t width) {
  line.append(width - std::min(width, text.size()), ' ').append(text);
}

std::string hex_bytes(Bytes bytes) {
  return fmt::format(FMT_COMPILE("{:02X}"), fmt::join(bytes, " "));
}

std::string words_text(std::span<const std::uint16_t> words) {
  if (words.empty()) return "no words";
  return fmt::format(FMT_COMPILE("{} 0x{:04X}"), words.size() == 1 ? "word" : "words",
                     fmt::join(words, " 0x"));
}

/// Of the slave itself, or when the address is left out: nothing.
std::string sub_slave_text(std::optional<SubSlave> sub_slave) {
  return !sub_slave || sub_slave->value == 0 ? "" : fmt::format(", sub-slave {}", sub_slave->value);
}

std::string element_text(Element element) {
  return element == kValueElement ? "" : fmt::format(" element {}", element.value());
}

std::string_view last_text(bool last) {
  return last ? " (last)" : "";
}

std::string text_of(const ActionCommand& action) {
  const std::string what = action.command == kCommandControlWord
                               ? fmt::format("control word 0x{:04X}", action.data_word)
                               : fmt::format("action {}, byte 0x{:02X}, word 0x{:04X}", action.command,
                                             action.data_byte, action.data_word);
  return fmt::format("broadcast to slaves {}: {}", format_slave_set(action.slaves.bits), what);
}

std::string text_of(const ReferenceTelegram& reference) {
  const std::string asks =
      reference.polled > 31 ? "asks nobody" : fmt::format("asks slave {}", reference.polled);
  return fmt::format("reference values, {}: {}", asks,
                     words_text(std::span(reference.word).first(reference.words)));
}

std::string text_of(const ActualTelegram& actual) {
  return fmt::format("actual values: {}", words_text(std::span(actual.word).first(actual.words)));
}

std::string text_of(const ParameterCommand& command) {
  std::string where = fmt::format("parameter {}{}", command.number.value(), element_text(command.element));
  switch (command.kind) {
    case ParameterCommand::Kind::read:
      return fmt::format("read {}{}", where, sub_slave_text(command.sub_slave));
    case ParameterCommand::Kind::write_word:
      return fmt::format("write {} = {} (0x{:04X}, word){}", where, command.value, command.value,
                         sub_slave_text(command.sub_slave));
    case ParameterCommand::Kind::write_doubleword:
      return fmt::format("write {} = {} (0x{:08X}, doubleword){}", where, command.value, command.value,
                         sub_slave_text(command.sub_slave));
  }
  return where;
}

std::string text_of(const TransferInitialise& start) {
  const bool upload = start.direction == TransferInitialise::Direction::upload;
  if (upload && start.length.value() == 0 && start.address == 0)
    return fmt::format("cancel transfer{}", sub_slave_text(start.sub_slave));
  return fmt::format("{} of {} {} 0x{:08X}{}", upload ? "begin upload" : "begin download",
                     text::counted(start.length.value(), "byte"), upload ? "from" : "to", start.address,
                     sub_slave_text(start.sub_slave));
}

std::string text_of(const UploadBlock& block) {
  return fmt::format("upload: asks for bytes from {}{}", block.offset.value(), last_text(block.last));
}

std::string text_of(const DownloadBlock& block) {
  return fmt::format("download: bytes from {}{}: {}", block.offset.value(), last_text(block.last),
                     hex_bytes(block.data));
}

std::string error_text(auto error) {
  return fmt::format("error 0x{:04X}, {}", static_cast<std::uint16_t>(error), meaning(error));
}

std::string text_of(const ParameterReply& reply, const std::optional<Telegram>& asked) {
  const std::string where = fmt::format("parameter {}", reply.number.value());
  if (reply.busy) return where + ": busy, to be asked again";
  if (reply.error) {
    const auto refused = error_answer(reply);
    if (!refused) return where + ": error without a code";
    return where + ": " + error_text(refused->error) + sub_slave_text(refused->sub_slave);
  }
  const auto* command = asked ? std::get_if<ParameterCommand>(&*asked) : nullptr;
  const bool known = command != nullptr && command->number == reply.number;
  // Without the command, lengths that only one answer can have still tell what it is.
  const auto answer = read_answer(reply);
  const bool read = known ? command->kind == ParameterCommand::Kind::read : answer && answer->sub_slave;
  if (!read) return where + ": written" + (known ? sub_slave_text(write_sub_slave(reply)) : std::string());
  if (!answer) return where + ": answer without a value";
  const std::string_view format = answer->doubleword ? "doubleword" : "word";
  return fmt::format("{} = {} (0x{:0{}X}, {}){}", where, answer->value, answer->value,
                     answer->doubleword ? 8 : 4, format, sub_slave_text(answer->sub_slave));
}

std::string text_of(const TransferReply& reply, const std::optional<Telegram>& asked) {
  const unsigned offset = reply.offset.value();
  if (reply.busy) return fmt::format("transfer, {}: busy, to be asked again", offset);
  if (reply.error) {
    const auto error = error_answer(reply);
    if (!error) return fmt::format("transfer, {}: error without a code", offset);
    return fmt::format("transfer, {}: {}", offset, error_text(*error));
  }
  if (const auto bytes = upload_bytes(reply)) {
    return fmt::format("upload: bytes from {}: {}", offset, hex_bytes(*bytes));
  }
  if (asked && std::holds_alternative<TransferInitialise>(*asked))
    return fmt::format("transfer accepted, length {}", offset);
  if (asked && std::holds_alternative<DownloadBlock>(*asked))
    return fmt::format("download: took bytes from {}", offset);
  return fmt::format("transfer, {}: accepted", offset);
}

/// Classes of error frames as SocketCAN numbers them (linux/can/error.h), named by their bits.
std::string error_classes(std::uint32_t id) {
  constexpr std::array<std::string_view, 9> kClasses{"transmit timeout",
                                                     "lost arbitration",
                                                     "controller problem",
                                                     "protocol violation",
                                                     "transceiver problem",
                                                     "not acknowledged",
                                                     "bus-off",
                                                     "bus error",
                                                     "controller restarted"};
  std::string out;
  for (std::size_t bit = 0; bit < kClasses.size(); ++bit)
    if (((id >> bit) & 1u) != 0) out += fmt::format("{}{}", out.empty() ? "" : ", ", kClasses[bit]);
  return out.empty() ? fmt::format("class 0x{:X}", id) : out;
}

std::string frame_text(const can::Frame& frame) {
  const Bytes data = Bytes(frame.data).first(std::min<std::size_t>(frame.dlc, frame.data.size()));
  return fmt::format("0x{:0{}X} [{}]{}{}", frame.id, frame.extended ? 8 : 3, frame.dlc,
                     data.empty() ? "" : " ", hex_bytes(data));
}

/// Channel of a frame by its identifier, also when the rest of it is no telegram.
std::string_view channel_name(const can::Frame& frame) {
  if (!frame.is_standard_data()) return "-";
  if (frame.id == identifier::action) return "CC";
  switch (identifier::channel_of(frame.id)) {
    case identifier::reference_one:
      return "WRC1";
    case identifier::reference_two:
      return "WRC2";
    case identifier::actual_one:
      return "RDC1";
    case identifier::actual_two:
      return "RDC2";
    case identifier::command:
      return "CC";
    case identifier::response:
      return "RC";
    default:
      return "-";
  }
}

void set_slave(TracedTelegram& out, unsigned slave) {
  out.slave = slave;
  out.slaves = 1u << slave;
}

}  // namespace

void TraceText::describe_command(const Telegram& telegram, TracedTelegram& out) {
  std::visit(
      [&out, &telegram, this](const auto& told) {
        using T = std::decay_t<decltype(told)>;
        if constexpr (std::is_same_v<T, ActionCommand>) {
          out.slaves = told.slaves.bits;
        } else if constexpr (std::is_same_v<T, ReferenceTelegram>) {
          if (told.polled <= 31) set_slave(out, told.polled);
        } else {
          set_slave(out, told.slave.value());
          if constexpr (!std::is_same_v<T, ActualTelegram>) asked_[told.slave.value()] = telegram;
        }
        if constexpr (!std::is_same_v<T, ParameterReply> && !std::is_same_v<T, TransferReply>)
          out.words = text_of(told);
      },
      telegram);
}

void TraceText::describe_answer(const Telegram& telegram, TracedTelegram& out) const {
  const auto tell = [&out, this](const auto& reply) {
    set_slave(out, reply.slave.value());
    out.words = text_of(reply, asked_[reply.slave.value()]);
  };
  if (const auto* parameter = std::get_if<ParameterReply>(&telegram)) tell(*parameter);
  if (const auto* transfer = std::get_if<TransferReply>(&telegram)) tell(*transfer);
}

TracedTelegram TraceText::describe(const can::CandumpLine& line) {
  const can::Frame& frame = line.frame;
  TracedTelegram out;
  out.time = line.time;
  if (frame.is_standard_data() && frame.id == sync_) {
    edge_ = line.time;
    out.channel = "SYNC";
    out.slaves = ~0u;
    out.words = frame.dlc == 0 ? "edge" : "edge, with data " + frame_text(frame);
  }
  if (edge_) out.after_sync = line.time - *edge_;
  if (!out.channel.empty()) return out;
  if (frame.error) {
    out.channel = "error";
    out.slaves = ~0u;
    out.words = "error frame: " + error_classes(frame.id);
    return out;
  }
  out.channel = channel_name(frame);
  const Decoded decoded = decode(frame);
  if (const auto* error = std::get_if<DecodeError>(&decoded)) {
    out.words = fmt::format("no CANsync telegram ({}): {}", name(*error), frame_text(frame));
    return out;
  }
  const auto& telegram = std::get<Telegram>(decoded);
  const bool answer =
      std::holds_alternative<ParameterReply>(telegram) || std::holds_alternative<TransferReply>(telegram);
  if (answer)
    describe_answer(telegram, out);
  else
    describe_command(telegram, out);
  return out;
}

std::vector<Table::Column> trace_columns() {
  constexpr auto left = Table::Align::left;
  constexpr auto right = Table::Align::right;
  return {
      {"TIME s", right, "as in the log; live: when the kernel had the frame, which is its end", kTimeWidth},
      {"SYNC+us", right, "since the newest SYNC frame of the log; - = none yet", kSinceWidth},
      {"CHANNEL", left,
       "RC, WRC1, RDC1, WRC2, RDC2, CC; SYNC; error = error frame; - = no channel of CANsync", kChannelWidth},
      {"SLAVE", right, "which is addressed, asked or sends; a broadcast names its slaves in the text",
       kSlaveWidth},
      {"WHAT", left, "the telegram in words; an answer is understood by the command before it"}};
}

std::string trace_heading() {
  return Table(trace_columns()).heading();
}

std::string trace_line(const TracedTelegram& telegram) {
  constexpr std::int64_t kSecond = 1'000'000;
  constexpr std::size_t kFraction = 7;  // ".000000"
  const std::int64_t time = telegram.time.count();
  const auto digits = [](const fmt::format_int& number) {
    return std::string_view(number.data(), number.size());
  };
  // As a line of the table, but in one step: a log may have ten million of them.
  std::string line;
  line.reserve(64 + telegram.words.size());
  add_right(line, digits(fmt::format_int(time / kSecond)), kTimeWidth - kFraction);
  fmt::format_to(std::back_inserter(line), FMT_COMPILE(".{:06}  "), time % kSecond);
  add_right(line, telegram.after_sync ? digits(fmt::format_int(telegram.after_sync->count())) : "-",
            kSinceWidth);
  line.append("  ").append(telegram.channel);
  line.append(kChannelWidth - std::min(kChannelWidth, telegram.channel.size()) + 2, ' ');
  add_right(line, telegram.slave ? digits(fmt::format_int(*telegram.slave)) : "-", kSlaveWidth);
  return line.append("  ").append(telegram.words);
}

}  // namespace cansync::cli
