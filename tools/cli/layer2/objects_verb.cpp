#include "cli/layer2/objects_verb.h"

#include <fmt/format.h>

#include <array>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cli/connect/bus_verb.h"
#include "cli/connect/gateway_reply.h"
#include "cli/layer2/frame_lines.h"
#include "cli/layer2/send_frames.h"
#include "cli/text/column_help.h"
#include "cli/text/values.h"
#include "layer2/client/frame_client.h"
#include "layer2/dds/convert.h"

namespace cansync::cli {
namespace {

using layer2::client::FrameClient;
using layer2::client::SendResult;

/// The arguments of `can objects` as they were typed.
struct ObjectTexts {
  std::string action;
  std::string number;
  std::string what;
  std::string timeout;
  bool on_remote = false;
  bool every_time = false;
  bool release = false;
  bool ask = false;
  bool transmit = false;
  bool tell = false;
};

std::vector<Table::Column> object_columns() {
  constexpr auto left = Table::Align::left;
  constexpr auto right = Table::Align::right;
  return {
      {"OBJECT", right, "number, 0 to 31: the lowest sends first, and receives first", 6},
      {"DIRECTION", left, "sends or receives", 9},
      {"ID", right, "identifier, hexadecimal", 8},
      {"MASK", right, "of one that receives: bits of the identifier that count", 8},
      {"STATE", left,
       "of one that sends: held (for remote frames), ready, in controller, or how its last job ended; of one "
       "that receives: closed, open, full, overrun",
       13},
      {"DATA", left, "bytes of the job, or of what was received last, hexadecimal", 23},
      {"SENT", right, "frames sent, since the start", 6},
      {"RECEIVED", right, "frames received, since the start", 8},
      {"OVERRUNS", right, "frames that came while it was full", 8}};
}

std::string_view state_text(const layer2_ObjectStatus& object) {
  if (!object.transmit) {
    if (object.overrun) return "overrun";
    return object.full ? "full" : (object.open ? "open" : "closed");
  }
  constexpr std::array<std::string_view, 4> kJobs = {"", "held", "ready", "in controller"};
  constexpr std::array<std::string_view, 4> kEnds = {"idle", "done", "aborted", "timed out"};
  const auto job = static_cast<std::size_t>(object.job);
  if (job != 0 && job < kJobs.size()) return kJobs[job];
  const auto end = static_cast<std::size_t>(object.ended_as);
  return end < kEnds.size() ? kEnds[end] : "?";
}

/// As can-utils write it.
std::string frame_words(const can::Frame& frame) {
  std::string text = identifier_text(frame) + "#";
  if (frame.remote) return text + fmt::format("R{}", frame.dlc);
  for (unsigned i = 0; i < frame.dlc; ++i) text += fmt::format("{:02X}", frame.data[i]);
  return text;
}

can::Frame of_object(const layer2_ObjectStatus& object) {
  can::Frame frame;
  frame.id = object.identifier;
  frame.extended = object.extended;
  return frame;
}

ExitCode show_objects(Session& session) {
  FrameClient client = connect_bus<FrameClient>(session);
  const auto objects = client.objects(session.search_time());
  Table table(object_columns());
  for (const layer2_ObjectStatus& object : objects) {
    const can::Frame content = layer2::dds::to_core(object.content);
    if (session.output().json()) {
      JsonObject line;
      line.add("number", object.number)
          .add("transmit", object.transmit)
          .add("identifier", object.identifier)
          .add("extended", object.extended)
          .add("mask", object.mask)
          .add("timeout_ms", object.timeout)
          .add("tell", object.tell)
          .add("state", state_text(object))
          .add("frame", frame_words(content))
          .add("time_ns", object.time)
          .add("sent", object.sent)
          .add("received", object.received)
          .add("overruns", object.overruns);
      session.output().object(line);
      continue;
    }
    table.add({fmt::format("{}", object.number), object.transmit ? "sends" : "receives",
               identifier_text(of_object(object)), object.transmit ? "-" : fmt::format("{:X}", object.mask),
               std::string(state_text(object)), data_text(content), fmt::format("{}", object.sent),
               fmt::format("{}", object.received), fmt::format("{}", object.overruns)});
  }
  if (session.output().json()) return ExitCode::done;
  session.output().table(table);
  if (objects.empty()) session.output().remark("no message object is set up");
  return ExitCode::done;
}

/// "123" or "123/7F0"; eight digits: 29 bits.
layer2_ObjectSettings parse_settings(const ObjectTexts& texts, std::uint8_t number) {
  const std::size_t slash = texts.what.find('/');
  const can::Frame identifier = parse_sent_frame(texts.what.substr(0, slash) + "#");
  layer2_ObjectSettings settings = {};
  settings.number = number;
  settings.identifier = identifier.identifier();
  settings.extended = identifier.extended;
  settings.mask = identifier.extended ? can::kExtendedIdentifierMask : can::kStandardIdentifierMask;
  settings.transmit = texts.transmit;
  settings.tell = texts.tell;
  if (slash != std::string::npos) {
    if (texts.transmit) throw UsageError("WHAT: a mask only of an object that receives, without --transmit");
    settings.mask = static_cast<std::uint32_t>(
        parse_integer("0x" + texts.what.substr(slash + 1), "WHAT: mask", 0, can::kExtendedIdentifierMask));
  }
  if (!texts.timeout.empty())
    settings.timeout = static_cast<std::uint32_t>(parse_integer(texts.timeout, "--timeout-ms", 0, 3'600'000));
  return settings;
}

constexpr std::string_view kActions = "send, abort, read, configure";

layer2_ObjectRequest parse_request(const ObjectTexts& texts, layer2_ObjectSettings& settings) {
  layer2_ObjectRequest request = {};
  request.number = static_cast<std::uint8_t>(parse_integer(texts.number, "NUMBER", 0, 31));
  const bool configures = texts.action == "configure";
  const bool sends = texts.action == "send";
  if ((configures || sends) == texts.what.empty())
    throw UsageError(texts.what.empty() ? "WHAT: missing; `send NUMBER ID#DATA`, `configure NUMBER ID[/MASK]`"
                                        : fmt::format("WHAT: not with {}", texts.action));
  if (!sends && (texts.on_remote || texts.every_time))
    throw UsageError("--on-remote, --every-time: only with send");
  if (texts.action != "read" && (texts.release || texts.ask))
    throw UsageError("--release, --ask: only with read");
  if (!configures && (texts.transmit || texts.tell || !texts.timeout.empty()))
    throw UsageError("--transmit, --tell, --timeout-ms: only with configure");
  if (sends) {
    request.action = layer2_OBJECT_SEND;
    request.content = layer2::dds::to_idl(parse_sent_frame(texts.what));
    request.on_remote = texts.on_remote || texts.every_time;
    request.every_time = texts.every_time;
  } else if (configures) {
    request.action = layer2_OBJECT_CONFIGURE;
    settings = parse_settings(texts, request.number);
    request.settings._buffer = &settings;
    request.settings._length = request.settings._maximum = 1;
  } else if (texts.action == "abort") {
    request.action = layer2_OBJECT_ABORT;
  } else if (texts.action == "read") {
    request.action = layer2_OBJECT_READ;
    request.release = texts.release || texts.ask;
    request.ask = texts.ask;
  } else {
    throw UsageError(fmt::format("ACTION: found '{}'; allowed: {}, or none", texts.action, kActions));
  }
  return request;
}

std::string done_text(const layer2_ObjectRequest& request, const SendResult& result) {
  switch (request.action) {
    case layer2_OBJECT_SEND:
      return request.on_remote ? "holds the frame for remote frames" : "frame sent";
    case layer2_OBJECT_ABORT:
      return "has no job";
    case layer2_OBJECT_CONFIGURE:
      return "configured";
    default:
      break;
  }
  return result.fresh ? "" : (request.release ? "nothing received yet; it is open" : "nothing received");
}

ExitCode objects_verb(Session& session, const ObjectTexts& texts) {
  if (texts.action.empty()) return show_objects(session);
  layer2_ObjectSettings settings = {};
  const layer2_ObjectRequest request = parse_request(texts, settings);
  FrameClient client = connect_bus<FrameClient>(session);
  const SendResult result = client.object(request);
  const bool sends = request.action == layer2_OBJECT_SEND;
  const can::Frame frame = sends ? layer2::dds::to_core(request.content) : result.content;
  JsonObject object;
  object.add("action", texts.action).add("number", request.number);
  sends || result.fresh ? object.add("frame", frame_words(frame)) : object.add_null("frame");
  object.add("overrun", result.overrun).add("time_ns", result.sent_time);
  if (result.fresh && !session.json()) {
    session.output().line(frame_words(frame));
    if (result.overrun) session.output().remark("another frame came while the object was full");
  }
  const std::string where = fmt::format("object {}", request.number);
  const std::string done = done_text(request, result);
  return session.finish(reply_of(result), object, where, done.empty() ? "" : where + ": " + done);
}

}  // namespace

void add_objects_verb(CLI::App& can, Verb& chosen) {
  auto* objects = can.add_subcommand("objects", "the 32 message objects: show, send, abort, read, configure");
  auto texts = std::make_shared<ObjectTexts>();
  objects
      ->add_option("ACTION", texts->action,
                   "what is to be done: send, abort, read, configure; none: show all")
      ->type_name("send|abort|read|configure");
  objects->add_option("NUMBER", texts->number, "of the object, 0..31");
  objects->add_option(
      "WHAT", texts->what,
      "send: the frame, ID#DATA as `can send` takes it; configure: ID or ID/MASK, hexadecimal, "
      "with eight digits of the identifier for 29 bits");
  objects->add_flag("--on-remote", texts->on_remote,
                    "send: hold the frame for one remote frame that asks for it");
  objects->add_flag("--every-time", texts->every_time, "send: hold it, and answer each remote frame");
  objects->add_flag("--release", texts->release, "read: open the object for the next frame");
  objects->add_flag("--ask", texts->ask, "read: open it, and send a remote frame for it");
  objects->add_flag("--transmit", texts->transmit, "configure: the object sends; without: it receives");
  objects->add_flag("--tell", texts->tell, "configure: each of its frames is an event (topic ModuleEvent)");
  objects
      ->add_option("--timeout-ms", texts->timeout,
                   "configure, with --transmit: when a job is aborted; 0: never")
      ->type_name("MS");
  objects->footer(
      "Of a bus with bus.protocol = \"layer2\". An object that receives is closed until it is read with --release.\n" +
      columns_help(object_columns()));
  run_when_named(*objects, chosen, texts, objects_verb);
}

}  // namespace cansync::cli
