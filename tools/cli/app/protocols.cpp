#include "cli/app/protocols.h"

#include <array>

#include "cli/cansync/status_lines.h"
#include "cli/cansync/verbs.h"
#include "cli/cansync_slave/status_part.h"
#include "cli/cansync_slave/verbs.h"
#include "cli/layer2/status_part.h"
#include "cli/layer2/verbs.h"

namespace cansync::cli {

std::span<const AddVerbs> protocol_verbs() noexcept {
  static constexpr std::array<AddVerbs, 3> kProtocols = {add_cansync_verbs, add_slave_role_verbs,
                                                         add_layer2_verbs};
  return kProtocols;
}

std::span<const StatusPart> protocol_status() noexcept {
  static const std::array<StatusPart, 3> kParts = {kMasterStatusPart, kSlaveStatusPart, kFrameStatusPart};
  return kParts;
}

}  // namespace cansync::cli
