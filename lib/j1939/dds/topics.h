#pragma once

#include <dds/dds.h>

#include <span>

#include "dds/gateway_topics.h"
#include "j1939.h"
#include "j1939_final.h"

/// Topics of j1939.idl; with those of gateway.idl all that a bus of J1939 has. docs/j1939.md shows the same
/// table; a test compares both.
namespace gateway::dds {

/// A stream of batches: a reader that is slow for a while gets the newest ones, and sees by their numbers
/// what it missed.
inline constexpr TopicQos kMessageStream = {.depth = 100};

GATEWAY_TOPIC(j1939, MessageBatch, kFromDaemon, kMessageStream);
/// Few and large: a reader that is slow gets the newest ones.
inline constexpr TopicQos kLongMessages = {.depth = 8};

GATEWAY_TOPIC(j1939, LongMessage, kFromDaemon, kLongMessages);
GATEWAY_TOPIC(j1939, MessageRequest, kFromClients, kind::request());
GATEWAY_TOPIC(j1939, MessageReply, kFromDaemon, kind::reply(4096, 2048));
GATEWAY_TOPIC(j1939, NodeStatus, kFromDaemon, kind::state());
GATEWAY_TOPIC(j1939, AddressTable, kFromDaemon, kind::state());
GATEWAY_TOPIC(j1939, FaultList, kFromDaemon, kind::state());

}  // namespace gateway::dds

namespace j1939::dds {

using namespace gateway::dds;  // what every protocol has

/// Every row, in the order of the IDL. Any thread; realtime safe.
std::span<const TopicInfo* const> all_topics() noexcept;

}  // namespace j1939::dds
