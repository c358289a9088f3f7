#pragma once

#include <string>

#include "cli/base/session.h"
#include "dds/denial.h"

namespace cansync::cli {

/// The reply to a request of any protocol as the rest of the command line takes it; `replied` false: none
/// came.
client::Reply reply_of(bool replied, gateway_ReplyCode code, gateway_RefusalCause cause, std::string reason);

/// The same for what the client of a protocol gives.
template <class Result>
client::Reply reply_of(const Result& result) {
  return reply_of(result.replied, result.code, result.cause, result.reason);
}

}  // namespace cansync::cli
