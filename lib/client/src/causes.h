#pragma once

#include <cansync/types.h>

#include "dds/ask/request_client.h"
#include "gateway.h"

/// Internal to lib/client.
namespace cansync::client::detail {

/// The cause of a reply of the daemon; `unknown` for a number that this library does not know.
RefusalCause to_cause(gateway_RefusalCause cause) noexcept;

/// Why a request was not begun; `other_daemon` also when no daemon is there.
RefusalCause cause_of(const gateway::dds::Ended& not_begun) noexcept;

}  // namespace cansync::client::detail
