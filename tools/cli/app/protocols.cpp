#include "cli/app/protocols.h"

#include <array>

namespace cansync::cli {

#define PROTOCOL(name) extern const ProtocolVerbs name##_verbs;
#include "protocols.def"
#undef PROTOCOL

std::span<const ProtocolVerbs* const> protocols() noexcept {
#define PROTOCOL(name) &name##_verbs,
  static constexpr auto kProtocols = std::to_array<const ProtocolVerbs*>({
#include "protocols.def"
  });
#undef PROTOCOL
  return kProtocols;
}

}  // namespace cansync::cli
