#include "cli/j1939/message_lines.h"

#include <fmt/format.h>

#include <array>

#include "cli/base/session.h"
#include "cli/dbc/dbc_file.h"
#include "cli/text/values.h"
#include "j1939/client/groups.h"
#include "j1939/identifier.h"
#include "j1939/transport.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

constexpr std::string_view kHexDigits = "0123456789ABCDEFabcdef";

const char* transport_text(j1939::Transport transport) {
  switch (transport) {
    case j1939::Transport::broadcast:
      return "broadcast";
    case j1939::Transport::connection:
      return "connection";
    case j1939::Transport::extended:
      return "extended";
    default:
      return "frame";
  }
}

j1939::Transport transport_of(j1939_MessageTransport transport) {
  switch (transport) {
    case j1939_TRANSPORT_BROADCAST:
      return j1939::Transport::broadcast;
    case j1939_TRANSPORT_CONNECTION:
      return j1939::Transport::connection;
    case j1939_TRANSPORT_EXTENDED:
      return j1939::Transport::extended;
    default:
      return j1939::Transport::frame;
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
  text.reserve(3 * bytes.size());
  for (const std::uint8_t byte : bytes) {
    if (!text.empty()) text += ' ';
    text += kHexDigits[byte >> 4];
    text += kHexDigits[byte & 0xF];
  }
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
          {"RANGE", right, "place in the configuration of the range that takes it; -: recorded", 5},
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

void MessageLines::show(const ShownMessage& message) {
  const auto [named, others] = names_.find(message.pgn, message.source, message.destination);
  const auto readings =
      named == nullptr ? std::vector<dbc::Reading>() : j1939::client::read_group(*named, message.data);
  if (output_.json()) {
    JsonObject object;
    object.add("time_ns", message.time)
        .add("interface", message.interface)
        .add("pgn", message.pgn)
        .add("priority", message.priority)
        .add("source", message.source)
        .add("destination", message.destination)
        .add("transport", transport_text(message.transport));
    message.range ? object.add("range", *message.range) : object.add_null("range");
    object.add("data", bytes_json(message.data));
    add_meaning(named, readings, object);
    object.add("other_messages", others);
    text_ += object.text() + '\n';
  } else {
    if (shown_ == 0) table_.append_heading(text_);
    const std::string time = time_text(message.time, true);
    const std::string pgn = pgn_text(message.pgn);
    const std::string priority = std::to_string(message.priority);
    const std::string source = std::to_string(message.source);
    const std::string destination = std::to_string(message.destination);
    const std::string range = message.range ? std::to_string(*message.range) : "-";
    const std::string length = std::to_string(message.data.size());
    const std::string data = bytes_text(message.data);
    const std::string meaning = named == nullptr ? "" : meaning_of(*named, readings, others);
    table_.append(text_, std::array<std::string_view, 10>{time, pgn, priority, source, destination,
                                                          transport_text(message.transport), range, length,
                                                          data, meaning});
  }
  ++shown_;
  if (text_.size() >= kMostWaiting) flush();
}

void MessageLines::flush() {
  if (!text_.empty()) output_.bytes(text_);
  text_.clear();
}

void MessageLines::show(const j1939_MessageBatch& batch) {
  tell_missed(batch);
  for (std::uint32_t i = 0; i < batch.messages._length && !enough(); ++i) {
    const j1939_ReceivedMessage& message = batch.messages._buffer[i];
    show({message.receive_time,
          bus_,
          message.pgn,
          message.priority,
          message.source,
          message.destination,
          transport_of(message.transport),
          message.range_index,
          {message.data._buffer, message.data._length}});
  }
}

void MessageLines::show(const j1939_LongMessage& message) {
  if (enough()) return;
  show({message.receive_time,
        bus_,
        message.pgn,
        message.priority,
        message.source,
        message.destination,
        j1939::Transport::extended,
        message.range_index,
        {message.data._buffer, message.data._length}});
}

}  // namespace cansync::cli
