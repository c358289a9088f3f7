#include "cli/layer2/image_verb.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <iterator>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "cli/base/endings.h"
#include "cli/base/interrupt.h"
#include "cli/connect/bus_verb.h"
#include "cli/connect/gateway_reply.h"
#include "cli/text/column_help.h"
#include "cli/text/values.h"
#include "layer2/client/frame_client.h"
#include "layer2/client/image_writer.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

using layer2::client::FrameClient;
using layer2::client::SendResult;
using std::chrono::milliseconds;

constexpr std::size_t kImage = 1024;
constexpr std::size_t kLine = 16;
/// Bytes that one request writes; more need an owner.
constexpr std::size_t kRequest = 64;

/// The arguments of `can image` as they were typed.
struct ImageTexts {
  std::string action;
  std::string address;
  std::vector<std::string> bytes;
  std::string count;
  std::string strength;
  bool hold = false;
};

std::string hex(std::span<const std::uint8_t> bytes, std::string_view between) {
  std::string text;
  for (const std::uint8_t byte : bytes) text += fmt::format("{}{:02X}", text.empty() ? "" : between, byte);
  return text;
}

std::vector<Table::Column> image_columns() {
  constexpr auto left = Table::Align::left;
  constexpr auto right = Table::Align::right;
  return {{"ADDRESS", right, "of the first of 16 bytes; lines that are all 0 on both sides are left out", 7},
          {"INPUTS", left, "bytes that came, hexadecimal", 47},
          {"OUTPUTS", left, "bytes that are sent, hexadecimal", 47}};
}

JsonArray telegrams_left_out(const layer2_ProcessImage& image) {
  JsonArray array;
  for (unsigned i = 0; i < image.telegrams; ++i) {
    if (image.telegram_left_out[i] == 0) continue;
    JsonObject one;
    one.add("identifier", image.telegram_identifier[i]).add("times", image.telegram_left_out[i]);
    array.add_json(one.text());
  }
  return array;
}

/// Whether telegrams are sent, and why not.
std::string_view sending_text(const layer2_ProcessImage& image) {
  if (!image.exchanging) return "in stop";
  if (image.sending) return "they are exchanged";
  return "none is sent until a program or a request writes the image";
}

/// What of the telegrams was lost; empty: none.
std::string losses_text(const layer2_ProcessImage& image) {
  std::string text;
  if (image.dropped != 0) text += fmt::format("; {} came that nothing is mapped for", image.dropped);
  if (image.left_out != 0) text += fmt::format("; {} left out: no room on the bus", image.left_out);
  for (unsigned i = 0; i < image.telegrams; ++i) {
    if (image.telegram_left_out[i] != 0)
      text += fmt::format(", {} of them 0x{:X}", image.telegram_left_out[i], image.telegram_identifier[i]);
  }
  return text;
}

void write_image(Session& session, const layer2_ProcessImage& image) {
  const std::span inputs(image.inputs);
  const std::span outputs(image.outputs);
  if (session.output().json()) {
    JsonObject object;
    object.add("time_ns", image.time)
        .add("exchanging", image.exchanging)
        .add("sending", image.sending)
        .add("writer", std::string_view(image.writer))
        .add("received", image.received)
        .add("dropped", image.dropped)
        .add("sent", image.sent)
        .add("left_out", image.left_out)
        .add("telegrams_left_out", telegrams_left_out(image))
        .add("inputs", hex(inputs, ""))
        .add("outputs", hex(outputs, ""));
    session.output().object(object);
    return;
  }
  const auto zero = [](std::span<const std::uint8_t> bytes) {
    return std::all_of(bytes.begin(), bytes.end(), [](std::uint8_t byte) { return byte == 0; });
  };
  Table table(image_columns());
  for (std::size_t at = 0; at < kImage; at += kLine) {
    const auto in = inputs.subspan(at, kLine);
    const auto out = outputs.subspan(at, kLine);
    if (!zero(in) || !zero(out)) table.add({fmt::format("{}", at), hex(in, " "), hex(out, " ")});
  }
  session.output().table(table);
  const std::string_view writer = std::string_view(image.writer);
  session.output().remark(fmt::format(
      "{} came, {} sent; {}{}{}", text::counted(image.received, "telegram"), image.sent, sending_text(image),
      writer.empty() ? std::string() : fmt::format("; written by {}", writer), losses_text(image)));
}

layer2_ProcessImage image_of(FrameClient& client, milliseconds time) {
  const auto image = client.image(time);
  if (!image)
    throw client::NoDaemon("the daemon has no process image: it needs [[mapped]] sections (" +
                           client.place() + ")");
  return *image;
}

ExitCode watch_image(Session& session, const ImageTexts& texts) {
  const std::uint64_t count = parse_end_count(texts.count);
  FrameClient client = connect_bus<FrameClient>(session);
  layer2_ProcessImage shown = image_of(client, session.search_time());
  write_image(session, shown);
  constexpr auto kLook = milliseconds(200);
  for (std::uint64_t n = 1; (count == 0 || n < count) && !interrupt_flag().load();) {
    const auto newest = client.image(kLook, true);
    if (stays_gone(client)) {
      return end_without_daemon(session, client.place());
    }
    const bool same =
        !newest || (std::equal(std::begin(shown.inputs), std::end(shown.inputs), newest->inputs) &&
                    std::equal(std::begin(shown.outputs), std::end(shown.outputs), newest->outputs) &&
                    shown.sending == newest->sending && shown.exchanging == newest->exchanging);
    if (same) continue;
    shown = *newest;
    write_image(session, shown);
    ++n;
  }
  return ExitCode::done;
}

std::vector<std::uint8_t> parse_image_bytes(const std::vector<std::string>& texts) {
  std::string digits;
  for (const std::string& text : texts) {
    if (text.size() % 2 != 0 || text.find_first_not_of("0123456789abcdefABCDEF") != std::string::npos)
      throw UsageError(
          fmt::format("BYTES: found '{}'; allowed: bytes of two hexadecimal digits, e.g. 0102FF", text));
    digits += text;
  }
  if (digits.empty())
    throw UsageError("BYTES: missing; allowed: bytes of two hexadecimal digits, e.g. 0102FF");
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i < digits.size(); i += 2)
    bytes.push_back(static_cast<std::uint8_t>(std::stoul(digits.substr(i, 2), nullptr, 16)));
  return bytes;
}

using Start = std::array<std::uint8_t, 16>;

/// Which start of the daemon serves the bus.
Start start_of(const FrameClient& client) {
  return std::to_array(client.gateway_status().daemon);
}

/// Throws Ended when another start of the daemon serves the bus than `start`: what that was told is lost.
void expect_same_start(const FrameClient& client, const Start& start, std::string_view lost) {
  if (start_of(client) == start) return;
  throw Ended(ExitCode::not_reachable,
              fmt::format("the daemon was started anew: {}; look at the module, then call this again", lost));
}

/// As owner, until Ctrl-C. The reply is made of what the daemon shows.
SendResult write_as_owner(Session& session, FrameClient& client, const ImageTexts& texts,
                          std::uint16_t address, const std::vector<std::uint8_t>& bytes) {
  const std::int64_t strength =
      texts.strength.empty() ? 0 : parse_integer(texts.strength, "--strength", 0, INT32_MAX);
  layer2::client::ImageWriter writer(client, static_cast<std::int32_t>(strength));
  SendResult result{{.replied = true, .code = gateway_REPLY_NO_ANSWER}};
  result.reason = writer.write(address, bytes);
  if (!result.reason.empty()) return result;
  result.reason =
      "the image does not have the bytes: a stronger writer owns it, or they were refused; see `cansync events`";
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(3);
  while (result.code != gateway_REPLY_DONE && std::chrono::steady_clock::now() < end) {
    const auto image = client.image(milliseconds(200), true);
    if (!image || !std::equal(bytes.begin(), bytes.end(), image->outputs + address)) continue;
    result.code = gateway_REPLY_DONE;
    result.reason.clear();
  }
  if (result.code != gateway_REPLY_DONE) return result;
  session.output().remark("the image is held until Ctrl-C");
  const Start start = start_of(client);
  while (!interrupt_flag().load()) {
    if (stays_gone(client)) throw client::NoDaemon("the daemon has gone (" + client.place() + ")");
    (void)client.image(milliseconds(200), true);
    if (client.daemon_present()) expect_same_start(client, start, "the image is not held any more");
  }
  return result;
}

SendResult write_by_request(FrameClient& client, std::uint16_t address,
                            const std::vector<std::uint8_t>& bytes) {
  layer2_ControlRequest request = {};
  request.kind = layer2_CONTROL_WRITE_IMAGE;
  request.address = address;
  request.size = static_cast<std::uint8_t>(bytes.size());
  std::copy(bytes.begin(), bytes.end(), request.bytes);
  return client.control(request);
}

ExitCode write_bytes(Session& session, const ImageTexts& texts) {
  const auto address = static_cast<std::uint16_t>(parse_integer(texts.address, "ADDRESS", 0, kImage - 1));
  const std::vector<std::uint8_t> bytes = parse_image_bytes(texts.bytes);
  if (address + bytes.size() > kImage)
    throw UsageError(fmt::format("BYTES: {} from {} on: end after the image; allowed: {}",
                                 text::counted(bytes.size(), "byte"), address, kImage - address));
  if (!texts.hold && bytes.size() > kRequest)
    throw UsageError(
        fmt::format("BYTES: found {}; allowed: {} at once, or more with --hold, as the image's owner",
                    text::counted(bytes.size(), "byte"), kRequest));
  if (!texts.hold && !texts.strength.empty()) throw UsageError("--strength: only with --hold");
  FrameClient client = connect_bus<FrameClient>(session);
  (void)image_of(client, session.search_time());
  const SendResult result = texts.hold ? write_as_owner(session, client, texts, address, bytes)
                                       : write_by_request(client, address, bytes);
  JsonObject object;
  object.add("address", address).add("bytes", hex(bytes, ""));
  return session.finish(reply_of(result), object, "image", text::counted(bytes.size(), "byte") + " written");
}

ExitCode image_verb(Session& session, const ImageTexts& texts) {
  if (texts.action == "write") return write_bytes(session, texts);
  if (!texts.address.empty() || texts.hold || !texts.strength.empty())
    throw UsageError("ADDRESS, --hold, --strength: only with write");
  if (texts.action == "watch") return watch_image(session, texts);
  if (!texts.action.empty())
    throw UsageError(fmt::format("ACTION: found '{}'; allowed: write, watch, or none", texts.action));
  FrameClient client = connect_bus<FrameClient>(session);
  write_image(session, image_of(client, session.search_time()));
  return ExitCode::done;
}

void show_lead(Session& session, const layer2_FrameStatus& status) {
  const std::string_view program = std::string_view(status.run_lead);
  if (session.output().json()) {
    JsonObject object;
    object.add("program", program).add("running", status.running);
    session.output().object(object);
  } else {
    session.output().line(fmt::format(
        "{}, {}", status.running ? "in run" : "in stop",
        program.empty() ? "no program is followed" : fmt::format("run and stop follow {}", program)));
  }
}

ExitCode lead_verb(Session& session, const std::string& name) {
  FrameClient client = connect_bus<FrameClient>(session);
  layer2::client::RunLead lead(client, name, 0);
  const std::string problem = lead.say(true);
  if (!problem.empty()) throw client::NoDaemon(problem);
  session.output().remark("the module is to run until Ctrl-C");
  const Start start = start_of(client);
  std::optional<layer2_FrameStatus> told;
  while (!interrupt_flag().load()) {
    if (stays_gone(client)) {
      return end_without_daemon(session, client.place());
    }
    (void)client.image(milliseconds(200), true);
    if (client.daemon_present())
      expect_same_start(client, start, "it does not know that the module is to run");
    const auto status = client.status(milliseconds(1));
    if (!status || (told && told->running == status->running &&
                    std::string_view(told->run_lead) == std::string_view(status->run_lead)))
      continue;
    told = *status;
    show_lead(session, *status);
  }
  return ExitCode::done;
}

}  // namespace

void add_image_verb(CLI::App& can, Verb& chosen) {
  auto* image = can.add_subcommand("image", "the process image: show, watch, write");
  auto texts = std::make_shared<ImageTexts>();
  image->add_option("ACTION", texts->action, "write, watch (until Ctrl-C, each change); none: show it once")
      ->type_name("write|watch");
  image->add_option("ADDRESS", texts->address, "write: first byte, 0..1023");
  image->add_option("BYTES", texts->bytes, "write: bytes of two hexadecimal digits, e.g. 0102FF");
  image->add_option("--count", texts->count, "watch: end after so many")->type_name("N");
  image->add_flag("--hold", texts->hold,
                  "write: own the image until Ctrl-C; nobody else writes it meanwhile");
  image
      ->add_option("--strength", texts->strength,
                   "write --hold: against others of less strength (0 and more; default 0)")
      ->type_name("N");
  image->footer(
      "Of a bus with bus.protocol = \"layer2\" and [[mapped]] sections. Up to 64 bytes stay written until a program "
      "writes the\nimage; with --hold, up to 1024 are written as its owner, and afterwards mapping.writer_lost says "
      "what becomes of it.\n" +
      columns_help(image_columns()));
  run_when_named(*image, chosen, texts, image_verb);
}

void add_lead_verb(CLI::App& can, Verb& chosen) {
  auto* lead = can.add_subcommand("lead", "let the module run until Ctrl-C");
  auto name = std::make_shared<std::string>();
  lead->add_option("PROGRAM", *name, "name that stands in module.run_follows")->required();
  lead->footer("Of a bus with bus.protocol = \"layer2\" whose module.run_follows has this name.");
  run_when_named(*lead, chosen, name, lead_verb);
}

}  // namespace cansync::cli
