#include "cansync/cluster/sub_slaves.h"

#include <algorithm>
#include <utility>

namespace cansync {
namespace {

std::uint16_t number_of_route(const SubSlaveRoute& route) noexcept {
  return route.number.value;
}

}  // namespace

SubSlaveTable::SubSlaveTable(std::vector<SubSlaveRoute> routes) : routes_(std::move(routes)) {
  std::ranges::stable_sort(routes_, {}, number_of_route);
}

std::optional<SubSlaveRoute> SubSlaveTable::find(SubSlave number) const noexcept {
  const auto found = std::ranges::lower_bound(routes_, number.value, {}, number_of_route);
  if (found == routes_.end() || found->number != number) return std::nullopt;
  return *found;
}

}  // namespace cansync
