#pragma once

#include <dds/dds.h>

#include <span>

#include "cansync_slave.h"
#include "cansync_slave_final.h"
#include "dds/gateway_topics.h"

/// Topics of cansync_slave.idl; with those of gateway.idl all that the bus of a slave has.
/// docs/cansync-slave.md shows the same table; a test compares both.
namespace gateway::dds {

GATEWAY_TOPIC(cansync_slave, ReferencesReceived, kFromDaemon, kind::state());
GATEWAY_TOPIC(cansync_slave, MonitoredValues, kFromDaemon, kind::state());
GATEWAY_TOPIC(cansync_slave, ActualRelease, kFromClients, kind::owned());
GATEWAY_TOPIC(cansync_slave, ActionReceived, kFromDaemon, kind::events());
/// A step of a job counts for who is there; nobody answers what is over.
inline constexpr TopicQos kStepQos = {.depth = 100};
GATEWAY_TOPIC(cansync_slave, ParameterJob, kFromDaemon, kStepQos);
GATEWAY_TOPIC(cansync_slave, BlockJob, kFromDaemon, kStepQos);
GATEWAY_TOPIC(cansync_slave, ApplicationAnswer, kFromClients, kind::owned());
GATEWAY_TOPIC(cansync_slave, SlaveCommand, kFromClients, kind::request());
GATEWAY_TOPIC(cansync_slave, SlaveCommandReply, kFromDaemon, kind::reply(256, 128));
GATEWAY_TOPIC(cansync_slave, SlaveSideStatus, kFromDaemon, kind::state());

}  // namespace gateway::dds

namespace cansync_slave::dds {

using namespace gateway::dds;  // what every protocol has

/// Every row, in the order of the IDL. Any thread; realtime safe.
std::span<const TopicInfo* const> all_topics() noexcept;

}  // namespace cansync_slave::dds
