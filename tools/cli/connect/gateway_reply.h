#pragma once

#include "cli/base/session.h"
#include "dds/ask/request_client.h"

namespace cansync::cli {

/// The reply to a request of any protocol as the rest of the command line takes it.
client::Reply reply_of(const gateway::dds::Ended& ended);

}  // namespace cansync::cli
