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
                                      .exclusive = true,
                                      .lease = kind::exclusive().lease,
                                      .offered_lease = kind::exclusive().offered_lease};

template <>
inline constexpr TopicInfo topic_info<layer2_FrameBatch> = {
    "FrameBatch", &layer2_FrameBatch_desc, kFromDaemon, kFrameStream, &layer2_FrameBatch_final_desc};
template <>
inline constexpr TopicInfo topic_info<layer2_SendRequest> = {
    "SendRequest", &layer2_SendRequest_desc, kFromClients, kind::request(), &layer2_SendRequest_final_desc};
template <>
inline constexpr TopicInfo topic_info<layer2_SendReply> = {
    "SendReply", &layer2_SendReply_desc, kFromDaemon, kind::reply(4096, 2048), &layer2_SendReply_final_desc};
template <>
inline constexpr TopicInfo topic_info<layer2_ControlRequest> = {"ControlRequest", &layer2_ControlRequest_desc,
                                                                kFromClients, kind::request(),
                                                                &layer2_ControlRequest_final_desc};
template <>
inline constexpr TopicInfo topic_info<layer2_ControlReply> = {"ControlReply", &layer2_ControlReply_desc,
                                                              kFromDaemon, kind::reply(4096, 2048),
                                                              &layer2_ControlReply_final_desc};
template <>
inline constexpr TopicInfo topic_info<layer2_ObjectRequest> = {"ObjectRequest", &layer2_ObjectRequest_desc,
                                                               kFromClients, kind::request(),
                                                               &layer2_ObjectRequest_final_desc};
template <>
inline constexpr TopicInfo topic_info<layer2_ObjectReply> = {"ObjectReply", &layer2_ObjectReply_desc,
                                                             kFromDaemon, kind::reply(4096, 2048),
                                                             &layer2_ObjectReply_final_desc};
template <>
inline constexpr TopicInfo topic_info<layer2_ObjectStatus> = {
    "ObjectStatus", &layer2_ObjectStatus_desc, kFromDaemon, kind::state(), &layer2_ObjectStatus_final_desc};
template <>
inline constexpr TopicInfo topic_info<layer2_ModuleEvent> = {
    "ModuleEvent", &layer2_ModuleEvent_desc, kFromDaemon, kFrameStream, &layer2_ModuleEvent_final_desc};
template <>
inline constexpr TopicInfo topic_info<layer2_ImageOutputs> = {"ImageOutputs", &layer2_ImageOutputs_desc,
                                                              kFromClients, kind::exclusive(),
                                                              &layer2_ImageOutputs_final_desc};
template <>
inline constexpr TopicInfo topic_info<layer2_RunLead> = {"RunLead", &layer2_RunLead_desc, kFromClients,
                                                         kRunLead, &layer2_RunLead_final_desc};
template <>
inline constexpr TopicInfo topic_info<layer2_TimerStatus> = {
    "TimerStatus", &layer2_TimerStatus_desc, kFromDaemon, kind::state(), &layer2_TimerStatus_final_desc};
template <>
inline constexpr TopicInfo topic_info<layer2_ProcessImage> = {
    "ProcessImage", &layer2_ProcessImage_desc, kFromDaemon, kind::state(), &layer2_ProcessImage_final_desc};
template <>
inline constexpr TopicInfo topic_info<layer2_FrameStatus> = {
    "FrameStatus", &layer2_FrameStatus_desc, kFromDaemon, kind::state(), &layer2_FrameStatus_final_desc};

}  // namespace gateway::dds

namespace layer2::dds {

using namespace gateway::dds;  // what every protocol has

/// Every row, in the order of the IDL. Any thread; realtime safe.
std::span<const TopicInfo* const> all_topics() noexcept;

}  // namespace layer2::dds
