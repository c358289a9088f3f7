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

template <>
inline constexpr TopicInfo topic_info<j1939_MessageBatch> = {
    "MessageBatch", &j1939_MessageBatch_desc, kFromDaemon, kMessageStream, &j1939_MessageBatch_final_desc};
/// Few and large: a reader that is slow gets the newest ones.
inline constexpr TopicQos kLongMessages = {.depth = 8};

template <>
inline constexpr TopicInfo topic_info<j1939_LongMessage> = {
    "LongMessage", &j1939_LongMessage_desc, kFromDaemon, kLongMessages, &j1939_LongMessage_final_desc};
template <>
inline constexpr TopicInfo topic_info<j1939_MessageRequest> = {"MessageRequest", &j1939_MessageRequest_desc,
                                                               kFromClients, kind::request(),
                                                               &j1939_MessageRequest_final_desc};
template <>
inline constexpr TopicInfo topic_info<j1939_MessageReply> = {"MessageReply", &j1939_MessageReply_desc,
                                                             kFromDaemon, kind::reply(4096, 2048),
                                                             &j1939_MessageReply_final_desc};
template <>
inline constexpr TopicInfo topic_info<j1939_NodeStatus> = {"NodeStatus", &j1939_NodeStatus_desc, kFromDaemon,
                                                           kind::state(), &j1939_NodeStatus_final_desc};
template <>
inline constexpr TopicInfo topic_info<j1939_AddressTable> = {
    "AddressTable", &j1939_AddressTable_desc, kFromDaemon, kind::state(), &j1939_AddressTable_final_desc};
template <>
inline constexpr TopicInfo topic_info<j1939_FaultList> = {"FaultList", &j1939_FaultList_desc, kFromDaemon,
                                                          kind::state(), &j1939_FaultList_final_desc};

}  // namespace gateway::dds

namespace j1939::dds {

using namespace gateway::dds;  // what every protocol has

/// Every row, in the order of the IDL. Any thread; realtime safe.
std::span<const TopicInfo* const> all_topics() noexcept;

}  // namespace j1939::dds
