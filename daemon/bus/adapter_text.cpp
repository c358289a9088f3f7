#include "daemon/bus/adapter_text.h"

#include <fmt/format.h>

#include "can/adapter/adapter.h"

namespace cansyncd {

std::string wrong_adapter_text(const BusConfig& bus, const can::LinkFacts& facts) {
  return fmt::format(
      "{} has the adapter {}, bus.adapter is {}: nothing is sent or received; plug the adapters in as they "
      "were, give them fixed names (cansync scan {} --write), or correct bus.adapter",
      bus.interface, can::words_of(facts.adapter), bus.adapter, bus.interface);
}

}  // namespace cansyncd
