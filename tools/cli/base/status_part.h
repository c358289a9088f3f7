#pragma once

#include <string_view>
#include <vector>

#include "cli/base/session.h"
#include "cli/text/column_help.h"

namespace cansync::cli {

/// What `status` shows of one protocol, beside what every bus has.
struct StatusPart {
  std::string_view protocol;                  ///< as GatewayStatus.protocol
  std::vector<Explained> (*lines)(Session&);  ///< label and text, in their order
  void (*members)(Session&, JsonObject&);     ///< of its status topic
  std::vector<Explained> (*help)();           ///< label and what its line says
};

}  // namespace cansync::cli
