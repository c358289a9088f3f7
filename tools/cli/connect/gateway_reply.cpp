#include "cli/connect/gateway_reply.h"

#include <utility>

namespace cansync::cli {
namespace {

client::ReplyCode reply_code_of(gateway_ReplyCode code) {
  using client::ReplyCode;
  switch (code) {
    case gateway_REPLY_DONE:
      return ReplyCode::done;
    case gateway_REPLY_SLAVE_ERROR:
      return ReplyCode::slave_error;
    case gateway_REPLY_TIMEOUT:
      return ReplyCode::timeout;
    case gateway_REPLY_NO_ANSWER:
      return ReplyCode::no_answer;
    case gateway_REPLY_CANCELLED:
      return ReplyCode::cancelled;
    case gateway_REPLY_MASTER_STOPPED:
      return ReplyCode::master_stopped;
    default:
      return ReplyCode::refused;
  }
}

}  // namespace

client::Reply reply_of(bool replied, gateway_ReplyCode code, gateway_RefusalCause cause, std::string reason) {
  client::Reply reply;
  reply.reason = std::move(reason);
  reply.code = replied ? reply_code_of(code) : client::ReplyCode::no_reply;
  // The numbers are those of the data model.
  if (reply.code == client::ReplyCode::refused) reply.cause = static_cast<client::RefusalCause>(cause);
  return reply;
}

}  // namespace cansync::cli
