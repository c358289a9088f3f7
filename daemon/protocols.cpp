#include "daemon/protocols.h"

#include <array>

namespace cansyncd {

#define PROTOCOL(name) extern const ProtocolInfo name##_protocol;
#include "protocols.def"
#undef PROTOCOL

std::span<const ProtocolInfo* const> protocols() noexcept {
#define PROTOCOL(name) &name##_protocol,
  static constexpr auto kProtocols = std::to_array<const ProtocolInfo*>({
#include "protocols.def"
  });
#undef PROTOCOL
  return kProtocols;
}

}  // namespace cansyncd
