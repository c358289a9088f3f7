#pragma once

#include "dds/topic.h"
#include "gateway.h"
#include "gateway_final.h"

/// Topics of gateway.idl, which every bus has.
namespace gateway::dds {

GATEWAY_TOPIC(gateway, JobCancel, kFromClients, kind::request());
GATEWAY_TOPIC(gateway, GatewayStatus, kFromDaemon, kind::state());
GATEWAY_TOPIC(gateway, BusStatus, kFromDaemon, kind::state());
GATEWAY_TOPIC(gateway, RealtimeStatus, kFromDaemon, kind::state());
GATEWAY_TOPIC(gateway, Event, kFromDaemon, kind::events());

}  // namespace gateway::dds
