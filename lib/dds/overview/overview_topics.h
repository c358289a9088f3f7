#pragma once

#include "dds/gateway_topics.h"
#include "overview.h"
#include "overview_final.h"

/// Topics of overview.idl.
namespace gateway::dds {

GATEWAY_TOPIC(gateway, JobEnd, kFromClients, kind::request());
GATEWAY_TOPIC(gateway, JobEndReply, kFromDaemon, kind::reply(1024, 256));
GATEWAY_TOPIC(gateway, OpenRequests, kFromDaemon, kind::state());
GATEWAY_TOPIC(gateway, DriveProfile, kFromDaemon, kind::state());

}  // namespace gateway::dds
