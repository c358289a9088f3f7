#include "cli/app/protocols.h"

#include <array>

#include "cli/cansync/verbs.h"

namespace cansync::cli {

std::span<const AddVerbs> protocol_verbs() noexcept {
  static constexpr std::array<AddVerbs, 1> kProtocols = {add_cansync_verbs};
  return kProtocols;
}

}  // namespace cansync::cli
