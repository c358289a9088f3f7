#pragma once

#include <cansync/types.h>

#include <utility>

#include "dds/entity.h"

/// Internal to lib/client.
namespace cansync::client::detail {

/// Makes something of DDS; what it cannot be made for is thrown as the SetupError that programs know.
template <class Make>
auto set_up(Make&& make) {
  try {
    return std::forward<Make>(make)();
  } catch (const gateway::dds::SetupError& error) {
    throw SetupError(error.what());
  }
}

}  // namespace cansync::client::detail
