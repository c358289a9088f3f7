#include "cli/layer2/send_reply.h"

#include <fmt/format.h>

#include <iterator>

namespace cansync::cli {

client::Reply to_reply(const layer2::client::SendResult& result) {
  using client::ReplyCode;
  client::Reply reply;
  reply.reason = result.reason;
  reply.code = ReplyCode::no_reply;
  if (!result.replied) return reply;
  switch (result.code) {
    case gateway_REPLY_DONE:
      reply.code = ReplyCode::done;
      break;
    case gateway_REPLY_TIMEOUT:
      reply.code = ReplyCode::timeout;
      break;
    case gateway_REPLY_NO_ANSWER:
      reply.code = ReplyCode::no_answer;
      break;
    case gateway_REPLY_CANCELLED:
      reply.code = ReplyCode::cancelled;
      break;
    case gateway_REPLY_MASTER_STOPPED:
      reply.code = ReplyCode::master_stopped;
      break;
    default:
      reply.code = ReplyCode::refused;
      // The numbers are those of the data model.
      reply.cause = static_cast<client::RefusalCause>(result.cause);
  }
  return reply;
}

std::string identifier_text(const layer2_CanFrame& frame) {
  return frame.extended ? fmt::format("{:08X}", frame.identifier) : fmt::format("{:03X}", frame.identifier);
}

std::string data_text(const layer2_CanFrame& frame) {
  if (frame.remote) return "remote";
  std::string text;
  for (unsigned i = 0; i < frame.length && i < std::size(frame.data); ++i)
    text += fmt::format("{}{:02X}", i == 0 ? "" : " ", frame.data[i]);
  return text;
}

void add_frame(const layer2_CanFrame& frame, JsonObject& object) {
  JsonArray data;
  for (unsigned i = 0; !frame.remote && i < frame.length && i < std::size(frame.data); ++i)
    data.add(frame.data[i]);
  object.add("identifier", frame.identifier)
      .add("extended", frame.extended)
      .add("remote", frame.remote)
      .add("length", frame.length)
      .add("data", data);
}

}  // namespace cansync::cli
