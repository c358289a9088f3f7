#pragma once

#include <cansync/types.h>

#include "gateway.h"

/// Internal to lib/client.
namespace cansync::client::detail {

/// The cause of a reply of the daemon; `unknown` for a number that this library does not know.
RefusalCause to_cause(gateway_RefusalCause cause) noexcept;

}  // namespace cansync::client::detail
