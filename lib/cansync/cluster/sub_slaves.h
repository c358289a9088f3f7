#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "cansync/telegram/numbers.h"

namespace cansync {

/// Where a gateway finds one participant below it. Its CANsync number is unique in the whole network
/// (O 7.1.1), and is the sub-slave address of every job for it, on every level.
struct SubSlaveRoute {
  SubSlave number;    ///< CANsync number, 1..65535
  SlaveNumber slave;  ///< of the lower bus: the participant itself, or the gateway on the way to it
  /// Sub-slave address in jobs on the lower bus: 0 for the slave itself, else, with numbers that are unique
  /// in the network, `number` again.
  SubSlave below;
  friend constexpr bool operator==(const SubSlaveRoute&, const SubSlaveRoute&) = default;
};

/// A gateway's table of the participants below it. All memory is taken in the constructor; looking something
/// up is realtime safe.
class SubSlaveTable {
 public:
  /// Of two routes for one number the first counts (`check` finds such).
  explicit SubSlaveTable(std::vector<SubSlaveRoute> routes);
  /// Nothing: no such participant is known.
  std::optional<SubSlaveRoute> find(SubSlave number) const noexcept;
  /// In the order of their numbers.
  const std::vector<SubSlaveRoute>& routes() const noexcept { return routes_; }

 private:
  std::vector<SubSlaveRoute> routes_;
};

}  // namespace cansync
