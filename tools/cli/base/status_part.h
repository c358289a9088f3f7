#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cli/base/finding_list.h"
#include "cli/base/session.h"
#include "cli/text/column_help.h"

namespace cansync::cli {

/// One bus in a few words; what its protocol does not have is empty.
struct BusSummary {
  struct Slaves {
    unsigned configured = 0;
    unsigned responding = 0;
  };
  std::string state;
  std::optional<Slaves> slaves;
};

/// What `status` shows of one protocol, beside what every bus has.
struct StatusPart {
  std::string_view protocol;                             ///< as GatewayStatus.protocol
  std::vector<Explained> (*lines)(Session&);             ///< label and text, in their order
  void (*members)(Session&, JsonObject&);                ///< of its status topic
  std::vector<Explained> (*help)();                      ///< label and what its line says
  BusSummary (*summary)(Session&) = nullptr;             ///< for `buses`; null: nothing to say
  std::vector<Finding> (*findings)(Session&) = nullptr;  ///< what `doctor` says of it; null: nothing
  bool has_sync = true;                                  ///< its bus has SYNC edges
  std::string_view reset_command = {};                   ///< resets its CAN controller; empty: it has none
};

}  // namespace cansync::cli
