#pragma once

#include <algorithm>
#include <optional>
#include <string_view>

#include "dds/bounded_text.h"
#include "gateway.h"
#include "layer2/status_image.h"

/// Internal to lib/client.
namespace cansync::client::detail {

/// What the daemon says of its controller, for STAT and the status image.
inline layer2::StatusFacts facts_of(const std::optional<gateway_BusStatus>& bus) {
  layer2::StatusFacts facts;
  if (!bus) return facts;
  const auto count = [](std::uint32_t errors) {
    return static_cast<std::uint16_t>(std::min<std::uint32_t>(errors, 255));
  };
  facts.bus_off = gateway::dds::text(bus->controller_state) == "bus-off";
  facts.transmit_errors = count(bus->transmit_errors);
  facts.receive_errors = count(bus->receive_errors);
  return facts;
}

}  // namespace cansync::client::detail
