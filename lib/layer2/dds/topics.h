#pragma once

#include <dds/dds.h>

#include <span>

#include "dds/gateway_topics.h"
#include "layer2.h"
#include "layer2_final.h"

/// Topics of layer2.idl; with those of gateway.idl all that a bus of layer 2 has. docs/layer2.md shows the
/// same table; a test compares both.
namespace gateway::dds {

/// A stream of batches: a reader that is slow for a while gets the newest ones, and sees by their numbers
/// what it missed.
inline constexpr TopicQos kFrameStream = {.depth = 100};

/// Who is the host stays so for a daemon that comes later.
inline constexpr TopicQos kRunLead = {.transient_local = true,
                                      .owned = true,
                                      .lease = kind::owned().lease,
                                      .offered_lease = kind::owned().offered_lease};

GATEWAY_TOPIC(layer2, FrameBatch, kFromDaemon, kFrameStream);
GATEWAY_TOPIC(layer2, SendRequest, kFromClients, kind::request());
GATEWAY_TOPIC(layer2, SendReply, kFromDaemon, kind::reply(4096, 2048));
GATEWAY_TOPIC(layer2, ControlRequest, kFromClients, kind::request());
GATEWAY_TOPIC(layer2, ControlReply, kFromDaemon, kind::reply(4096, 2048));
GATEWAY_TOPIC(layer2, ObjectRequest, kFromClients, kind::request());
GATEWAY_TOPIC(layer2, ObjectReply, kFromDaemon, kind::reply(4096, 2048));
GATEWAY_TOPIC(layer2, ObjectStatus, kFromDaemon, kind::state());
GATEWAY_TOPIC(layer2, ModuleEvent, kFromDaemon, kFrameStream);
GATEWAY_TOPIC(layer2, ImageOutputs, kFromClients, kind::owned());
GATEWAY_TOPIC(layer2, RunLead, kFromClients, kRunLead);
GATEWAY_TOPIC(layer2, TimerStatus, kFromDaemon, kind::state());
GATEWAY_TOPIC(layer2, ProcessImage, kFromDaemon, kind::state());
GATEWAY_TOPIC(layer2, FrameStatus, kFromDaemon, kind::state());

}  // namespace gateway::dds

namespace layer2::dds {

using namespace gateway::dds;  // what every protocol has

/// Every row, in the order of the IDL. Any thread; realtime safe.
std::span<const TopicInfo* const> all_topics() noexcept;

}  // namespace layer2::dds
