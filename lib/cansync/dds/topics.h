#pragma once

#include <dds/dds.h>

#include <span>

#include "cansync.h"
#include "cansync_final.h"
#include "dds/gateway_topics.h"

/// Topics of cansync.idl; with those of gateway.idl all that a bus of CANsync has. docs/dds-api.md shows the
/// same table; a test compares both.
namespace gateway::dds {

GATEWAY_TOPIC(cansync, ActualValues, kFromDaemon, kind::state());
GATEWAY_TOPIC(cansync, ReferenceValues, kFromClients, kind::owned());
GATEWAY_TOPIC(cansync, Interval, kFromDaemon, kind::latest());
GATEWAY_TOPIC(cansync, ParameterRequest, kFromClients, kind::request());
GATEWAY_TOPIC(cansync, ParameterReply, kFromDaemon, kind::reply(4096, 2048));
GATEWAY_TOPIC(cansync, TransferRequest, kFromClients, kind::request());
GATEWAY_TOPIC(cansync, TransferProgress, kFromDaemon, kind::latest());
GATEWAY_TOPIC(cansync, TransferReply, kFromDaemon, kind::reply(16, 64));
GATEWAY_TOPIC(cansync, Command, kFromClients, kind::request());
GATEWAY_TOPIC(cansync, CommandReply, kFromDaemon, kind::reply(4096, 2048));
GATEWAY_TOPIC(cansync, MasterStatus, kFromDaemon, kind::state());
GATEWAY_TOPIC(cansync, SlaveStatus, kFromDaemon, kind::state());
GATEWAY_TOPIC(cansync, Timing, kFromDaemon, kind::latest());

}  // namespace gateway::dds

namespace cansync::dds {

using namespace gateway::dds;  // what every protocol has

/// Commands that only engineers may give, of the type of Command; used with DDS Security alone, whose
/// permissions are by topic.
inline constexpr TopicInfo kEngineerCommandTopic = {"EngineerCommand", &cansync_Command_desc, kFromClients,
                                                    kind::request(), &cansync_Command_final_desc};

/// Does the command go over that topic when DDS Security is on? True also for kinds that are not known.
bool for_engineers(cansync_CommandKind kind) noexcept;

/// Every row, in the order of the IDL.
std::span<const TopicInfo* const> all_topics() noexcept;

}  // namespace cansync::dds
