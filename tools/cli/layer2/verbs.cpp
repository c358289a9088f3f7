#include "cli/layer2/verbs.h"

#include <fmt/format.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cli/base/interrupt.h"
#include "cli/connect/bus_connection.h"
#include "cli/connect/gateway_reply.h"
#include "cli/layer2/control_verbs.h"
#include "cli/layer2/frame_lines.h"
#include "cli/layer2/status_part.h"
#include "cli/text/column_help.h"
#include "cli/text/values.h"
#include "layer2/client/frame_client.h"
#include "layer2/dds/convert.h"

namespace cansync::cli {
namespace {

using layer2::client::FrameClient;

constexpr std::size_t kMostData = 8;

/// The arguments of `send` as they were typed.
struct SendTexts {
  std::string identifier;
  std::string data;
  std::string length;
  bool extended = false;
  bool remote = false;
  layer2::client::SendChoice choice;
};

/// "0102FF", also with blanks or dots between the bytes.
void parse_data(std::string_view text, can::Frame& frame) {
  const std::string wrong =
      fmt::format("DATA: found '{}'; allowed: up to 8 bytes of two hexadecimal digits, e.g. 0102FF", text);
  std::string digits;
  for (const char digit : text) {
    if (digit != ' ' && digit != '.') {
      digits += digit;
    } else if (digits.size() % 2 != 0) {
      throw UsageError(wrong);  // "1 2" is no 12
    }
  }
  if (digits.size() % 2 != 0 || digits.size() > 2 * kMostData) throw UsageError(wrong);
  if (digits.find_first_not_of("0123456789abcdefABCDEF") != std::string::npos) throw UsageError(wrong);
  for (std::size_t i = 0; i < digits.size(); i += 2)
    frame.data[frame.dlc++] = static_cast<std::uint8_t>(std::stoul(digits.substr(i, 2), nullptr, 16));
}

/// Hexadecimal, as `frames` and candump show it. Without 0x it must have all its digits: a decimal number
/// would be another identifier.
std::uint32_t parse_identifier(std::string_view text, bool extended) {
  const std::size_t width = extended ? 8 : 3;
  const auto largest = extended ? can::kExtendedIdentifierMask : can::kStandardIdentifierMask;
  const std::string wrong =
      fmt::format("ID: found '{}'; allowed: {} hexadecimal digits, {:0{}X}..{:0{}X}, or with 0x fewer{}",
                  text, width, 0, width, largest, width, extended ? "" : "; 29 bits: --extended");
  const bool marked = text.starts_with("0x") || text.starts_with("0X");
  const std::string digits(text.substr(marked ? 2 : 0));
  if (digits.empty() || digits.size() > width || (!marked && digits.size() != width)) throw UsageError(wrong);
  if (digits.find_first_not_of("0123456789abcdefABCDEF") != std::string::npos) throw UsageError(wrong);
  const unsigned long identifier = std::stoul(digits, nullptr, 16);
  if (identifier > largest) throw UsageError(wrong);
  return static_cast<std::uint32_t>(identifier);
}

can::Frame parse_frame(const SendTexts& texts) {
  can::Frame frame;
  frame.extended = texts.extended;
  frame.remote = texts.remote;
  frame.id = parse_identifier(texts.identifier, frame.extended);
  if (!frame.remote) {
    if (!texts.length.empty()) throw UsageError("--length: only with --remote; else DATA has the length");
    parse_data(texts.data, frame);
    return frame;
  }
  if (!texts.data.empty()) throw UsageError("DATA: not with --remote, which asks for it");
  if (!texts.length.empty())
    frame.dlc = static_cast<std::uint8_t>(parse_integer(texts.length, "--length", 0, kMostData));
  return frame;
}

ExitCode send_verb(Session& session, const SendTexts& texts) {
  const can::Frame frame = parse_frame(texts);
  FrameClient client = connect_bus<layer2::client::FrameClient>(session);
  (void)client.status(session.search_time());
  const layer2::client::SendResult result = client.send(frame, session.monitoring_ms(), texts.choice);
  const layer2_CanFrame shown = layer2::dds::to_idl(frame);
  JsonObject object;
  add_frame(shown, object);
  object.add("sent_time_ns", result.sent_time);
  const std::string where = fmt::format("frame {}", identifier_text(shown));
  return session.finish(reply_of(result), object, where, where + " sent");
}

std::vector<Table::Column> frame_columns() {
  constexpr auto left = Table::Align::left;
  constexpr auto right = Table::Align::right;
  return {{"TIME", left, "when its last bit was on the bus, in the time zone of this computer", 23},
          {"ID", right, "identifier, hexadecimal: three digits for 11 bits, eight for 29", 8},
          {"LEN", right, "length in bytes, 0 to 8", 3},
          {"DATA", left, "the bytes, hexadecimal; remote: a frame that asks for them", 23},
          {"RANGE", right, "place in the configuration of the range that takes it", 5}};
}

/// Writes frames until `count` are there; 0: without end.
class FrameLines {
 public:
  FrameLines(Output& output, std::uint64_t count) : output_(output), table_(frame_columns()), count_(count) {}

  void show(const layer2_FrameBatch& batch);
  bool enough() const noexcept { return count_ != 0 && shown_ == count_; }

 private:
  void tell_missed(const layer2_FrameBatch& batch);

  Output& output_;
  Table table_;
  std::uint64_t count_;
  std::uint64_t shown_ = 0;
  std::uint64_t number_ = 0;  ///< of the last batch; 0: none yet
  std::uint64_t lost_ = 0;
};

void FrameLines::tell_missed(const layer2_FrameBatch& batch) {
  if (number_ != 0 && batch.number <= number_) {
    output_.remark("the daemon was started anew; frames may have been missed");
    number_ = 0;
  }
  if (number_ != 0 && batch.number != number_ + 1)
    output_.remark(fmt::format("{} batches of frames were missed", batch.number - number_ - 1));
  if (number_ != 0 && batch.lost != lost_)
    output_.remark(fmt::format("{} frames came faster than the daemon could publish", batch.lost - lost_));
  number_ = batch.number;
  lost_ = batch.lost;
}

void FrameLines::show(const layer2_FrameBatch& batch) {
  tell_missed(batch);
  for (std::uint32_t i = 0; i < batch.frames._length && !enough(); ++i) {
    const layer2_ReceivedFrame& frame = batch.frames._buffer[i];
    if (output_.json()) {
      JsonObject object;
      object.add("time_ns", frame.receive_time);
      add_frame(frame.received, object);
      object.add("range", frame.range_index).add("high_priority", frame.high_priority);
      output_.object(object);
    } else {
      if (shown_ == 0) output_.line(table_.heading());
      output_.line(table_.line({time_text(frame.receive_time, true), identifier_text(frame.received),
                                fmt::format("{}", frame.received.length), data_text(frame.received),
                                fmt::format("{}", frame.range_index)}));
    }
    ++shown_;
  }
}

ExitCode frames_verb(Session& session, const std::string& count_text) {
  const std::uint64_t count =
      count_text.empty() ? 0 : static_cast<std::uint64_t>(parse_integer(count_text, "--count", 1, INT32_MAX));
  FrameClient client = connect_bus<layer2::client::FrameClient>(session);
  FrameLines lines(session.output(), count);
  constexpr auto kLook = std::chrono::milliseconds(200);
  while (!interrupt_flag().load() && !lines.enough()) {
    if (client.receive(kLook, [&lines](const layer2_FrameBatch& batch) { lines.show(batch); })) continue;
    session.output().remark("the daemon has gone (" + client.place() + ")");
    return ExitCode::not_reachable;
  }
  return ExitCode::done;
}

void add_frames(CLI::App& app, Verb& chosen) {
  auto* frames = app.add_subcommand("frames", "general frames: what the bus carries, until Ctrl-C");
  auto count = std::make_shared<std::string>();
  frames->add_option("--count", *count, "end after so many frames")->type_name("N");
  frames->footer("Of a bus with bus.protocol = \"layer2\": frames of other nodes that its ranges take.\n" +
                 columns_help(frame_columns()));
  frames->callback(
      [count, &chosen] { chosen = [count](Session& session) { return frames_verb(session, *count); }; });
}

void add_send(CLI::App& app, Verb& chosen) {
  auto* send = app.add_subcommand("send", "general frames: send one");
  auto texts = std::make_shared<SendTexts>();
  send->add_option("ID", texts->identifier,
                   "identifier in three hexadecimal digits, 000..7FF; with --extended in eight; or 0x..")
      ->required();
  send->add_option("DATA", texts->data,
                   "up to 8 bytes of two hexadecimal digits, e.g. 0102FF; none: no data");
  send->add_flag("--extended", texts->extended, "29-bit identifier; without: 11 bits");
  send->add_flag("--remote", texts->remote, "ask for the data instead of sending some");
  send->add_option("--length", texts->length, "with --remote: bytes asked for, 0..8 (default 0)")
      ->type_name("N");
  send->add_flag("--high", texts->choice.high_priority,
                 "wait in the queue of high priority, which is sent first");
  send->add_flag("--by-id", texts->choice.by_identifier,
                 "wait in front of frames that lose the arbitration against it, second at best");
  send->footer(
      "Of a bus with bus.protocol = \"layer2\". Done means that the frame was on the bus; without an answer it may "
      "have\nbeen, or be sent yet.");
  send->callback(
      [texts, &chosen] { chosen = [texts](Session& session) { return send_verb(session, *texts); }; });
}

void add_verbs_of_layer2(CLI::App& app, Verb& chosen) {
  add_frames(app, chosen);
  add_send(app, chosen);
  add_control_verbs(app, chosen);
}

}  // namespace

const ProtocolVerbs layer2_verbs = {add_verbs_of_layer2, &kFrameStatusPart};

}  // namespace cansync::cli
