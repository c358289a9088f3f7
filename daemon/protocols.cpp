#include "daemon/protocols.h"

#include <array>

#include "daemon/cansync/segment/master_protocol.h"
#include "daemon/cansync_slave/segment/slave_protocol.h"
#include "daemon/layer2/segment/layer2_protocol.h"

namespace cansyncd {
namespace {

/// The only list of protocols.
constexpr auto kProtocols = std::to_array<const ProtocolInfo*>({
    &cansync_master,
    &cansync_slave_protocol,
    &layer2_protocol,
});

}  // namespace

std::span<const ProtocolInfo* const> protocols() noexcept {
  return kProtocols;
}

}  // namespace cansyncd
