#include "cli/connect/gateway_reply.h"

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
    case gateway_REPLY_REPLACED:
      return ReplyCode::replaced;
    case gateway_REPLY_SLAVE_LOST:
      return ReplyCode::slave_lost;
    case gateway_REPLY_WORD_EXPECTED:
      return ReplyCode::word_expected;
    case gateway_REPLY_DOUBLEWORD_EXPECTED:
      return ReplyCode::doubleword_expected;
    case gateway_REPLY_VALUE_TOO_WIDE:
      return ReplyCode::value_too_wide;
    case gateway_REPLY_REFUSED:
      break;
  }
  return ReplyCode::refused;
}

}  // namespace

client::Reply reply_of(const gateway::dds::Ended& ended) {
  client::Reply reply;
  reply.reason = ended.reason;
  reply.code = ended.replied ? reply_code_of(ended.code) : client::ReplyCode::no_reply;
  // The numbers are those of the data model.
  if (reply.code == client::ReplyCode::refused) reply.cause = static_cast<client::RefusalCause>(ended.cause);
  return reply;
}

}  // namespace cansync::cli
