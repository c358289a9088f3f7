#include "cli/app/protocols.h"

#include <array>

#include "cli/cansync/verbs.h"
#include "cli/layer2/verbs.h"

namespace cansync::cli {

std::span<const AddVerbs> protocol_verbs() noexcept {
  static constexpr std::array<AddVerbs, 2> kProtocols = {add_cansync_verbs, add_layer2_verbs};
  return kProtocols;
}

}  // namespace cansync::cli
