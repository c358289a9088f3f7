#pragma once

#include "dds/gateway_topics.h"
#include "overview.h"
#include "overview_final.h"

/// Topics of overview.idl.
namespace gateway::dds {

template <>
inline constexpr TopicInfo topic_info<gateway_JobEnd> = {"JobEnd", &gateway_JobEnd_desc, kFromClients,
                                                         kind::request(), &gateway_JobEnd_final_desc};
template <>
inline constexpr TopicInfo topic_info<gateway_JobEndReply> = {"JobEndReply", &gateway_JobEndReply_desc,
                                                              kFromDaemon, kind::reply(1024, 256),
                                                              &gateway_JobEndReply_final_desc};
template <>
inline constexpr TopicInfo topic_info<gateway_OpenRequests> = {
    "OpenRequests", &gateway_OpenRequests_desc, kFromDaemon, kind::state(), &gateway_OpenRequests_final_desc};
template <>
inline constexpr TopicInfo topic_info<gateway_DriveProfile> = {
    "DriveProfile", &gateway_DriveProfile_desc, kFromDaemon, kind::state(), &gateway_DriveProfile_final_desc};

}  // namespace gateway::dds
