#include "cli/j1939/message_lines.h"

#include <fmt/format.h>

#include "cli/base/session.h"
#include "cli/dbc/dbc_file.h"
#include "cli/text/values.h"
#include "j1939/client/groups.h"
#include "j1939/identifier.h"
#include "j1939/transport.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

constexpr std::string_view kHexDigits = "0123456789abcdefABCDEF";

const char* transport_text(j1939_MessageTransport transport) {
  switch (transport) {
    case j1939_TRANSPORT_BROADCAST:
      return "broadcast";
    case j1939_TRANSPORT_CONNECTION:
      return "connection";
    case j1939_TRANSPORT_EXTENDED:
      return "extended";
    default:
      return "frame";
  }
}

}  // namespace

std::string pgn_text(std::uint32_t pgn) {
  return fmt::format("{:05X}", pgn);
}

std::uint32_t parse_pgn(std::string_view text) {
  const std::string wrong =
      fmt::format("PGN: found '{}'; allowed: five hexadecimal digits, 00000..3FFFF, or with 0x fewer", text);
  const bool marked = text.starts_with("0x") || text.starts_with("0X");
  const std::string digits(text.substr(marked ? 2 : 0));
  constexpr std::size_t kDigits = 5;
  if (digits.empty() || digits.size() > kDigits || (!marked && digits.size() != kDigits))
    throw UsageError(wrong);
  if (digits.find_first_not_of(kHexDigits) != std::string::npos) throw UsageError(wrong);
  const auto pgn = static_cast<std::uint32_t>(std::stoul(digits, nullptr, 16));
  if (pgn > j1939::kLargestPgn) throw UsageError(wrong);
  if (!j1939::is_pgn(pgn))
    throw UsageError(
        fmt::format("PGN: found '{}', whose lowest byte is the destination's place; allowed: {}, "
                    "and the destination by --to",
                    text, pgn_text(pgn & ~0xFFu)));
  return pgn;
}

std::uint8_t parse_address(std::string_view text, std::string_view what) {
  if (text == "all") return j1939::kGlobalAddress;
  const auto address = parse_integer(text, what, 0, j1939::kGlobalAddress);
  if (address == j1939::kNullAddress)
    throw UsageError(fmt::format("{}: found 254, which nobody has; allowed: 0..253, or all", what));
  return static_cast<std::uint8_t>(address);
}

std::string bytes_text(std::span<const std::uint8_t> bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) text += fmt::format("{}{:02X}", text.empty() ? "" : " ", byte);
  return text;
}

std::vector<std::uint8_t> parse_bytes(std::string_view text) {
  const std::string wrong =
      fmt::format("DATA: found '{}'; allowed: up to {} bytes of two hexadecimal digits, e.g. 0102FF",
                  text.substr(0, 40), j1939::kMostBytes);
  std::string digits;
  for (const char digit : text) {
    if (digit != ' ' && digit != '.') {
      digits += digit;
    } else if (digits.size() % 2 != 0) {
      throw UsageError(wrong);  // "1 2" is no 12
    }
  }
  if (digits.size() % 2 != 0 || digits.size() > 2 * j1939::kMostBytes) throw UsageError(wrong);
  if (digits.find_first_not_of(kHexDigits) != std::string::npos) throw UsageError(wrong);
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i < digits.size(); i += 2)
    bytes.push_back(static_cast<std::uint8_t>(std::stoul(digits.substr(i, 2), nullptr, 16)));
  return bytes;
}

JsonArray bytes_json(std::span<const std::uint8_t> bytes) {
  JsonArray array;
  for (const std::uint8_t byte : bytes) array.add(byte);
  return array;
}

std::vector<Table::Column> message_columns() {
  constexpr auto left = Table::Align::left;
  constexpr auto right = Table::Align::right;
  return {{"TIME", left, "when its last bit was on the bus, in the time zone of this computer", 23},
          {"PGN", right, "group, hexadecimal", 5},
          {"PRIO", right, "priority, 0 (most urgent) to 7", 4},
          {"FROM", right, "address of the node that sent it", 4},
          {"TO", right, "address of the node it is for; 255: all", 3},
          {"BY", left,
           "frame, or in packets: broadcast to all, connection to one; extended: over 1785 bytes to one", 10},
          {"RANGE", right, "place in the configuration of the range that takes it", 5},
          {"LEN", right, "length in bytes, 0 to 1048576", 4},
          {"DATA", left, "the bytes, hexadecimal", 23},
          {"MEANING", left, "with --dbc: message and signals, with unit and name of the value", 7}};
}

void MessageLines::tell_missed(const j1939_MessageBatch& batch) {
  if (number_ != 0 && batch.number <= number_) {
    output_.remark("the daemon was started anew; messages may have been missed");
    number_ = 0;
  }
  if (number_ != 0 && batch.number != number_ + 1)
    output_.remark(text::counted(batch.number - number_ - 1, "batch of messages was missed",
                                 "batches of messages were missed"));
  if (number_ != 0 && batch.lost != lost_)
    output_.remark(fmt::format("{} came faster than the daemon could publish",
                               text::counted(batch.lost - lost_, "message")));
  number_ = batch.number;
  lost_ = batch.lost;
}

void MessageLines::show(const j1939_ReceivedMessage& message, std::span<const std::uint8_t> data) {
  const dbc::Message* const named = j1939::client::find_group(names_, message.pgn, message.source);
  const auto readings =
      named == nullptr ? std::vector<dbc::Reading>() : j1939::client::read_group(*named, data);
  if (output_.json()) {
    JsonObject object;
    object.add("time_ns", message.receive_time)
        .add("pgn", message.pgn)
        .add("priority", message.priority)
        .add("source", message.source)
        .add("destination", message.destination)
        .add("transport", transport_text(message.transport))
        .add("range", message.range_index)
        .add("data", bytes_json(data));
    add_meaning(named, readings, object);
    output_.object(object);
    return;
  }
  if (shown_ == 0) output_.line(table_.heading());
  output_.line(table_.line({time_text(message.receive_time, true), pgn_text(message.pgn),
                            fmt::format("{}", message.priority), fmt::format("{}", message.source),
                            fmt::format("{}", message.destination), transport_text(message.transport),
                            fmt::format("{}", message.range_index), fmt::format("{}", data.size()),
                            bytes_text(data), named == nullptr ? "" : meaning_of(*named, readings)}));
}

void MessageLines::show(const j1939_MessageBatch& batch) {
  tell_missed(batch);
  for (std::uint32_t i = 0; i < batch.messages._length && !enough(); ++i) {
    const j1939_ReceivedMessage& message = batch.messages._buffer[i];
    show(message, {message.data._buffer, message.data._length});
    ++shown_;
  }
}

void MessageLines::show(const j1939_LongMessage& message) {
  if (enough()) return;
  j1939_ReceivedMessage head = {};
  head.pgn = message.pgn;
  head.priority = message.priority;
  head.source = message.source;
  head.destination = message.destination;
  head.transport = j1939_TRANSPORT_EXTENDED;
  head.receive_time = message.receive_time;
  head.range_index = message.range_index;
  show(head, {message.data._buffer, message.data._length});
  ++shown_;
}

}  // namespace cansync::cli
