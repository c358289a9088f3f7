#pragma once

#include "dds/topic.h"
#include "gateway.h"
#include "gateway_final.h"

/// Topics of gateway.idl, which every bus has.
namespace gateway::dds {

template <>
inline constexpr TopicInfo topic_info<gateway_JobCancel> = {
    "JobCancel", &gateway_JobCancel_desc, kFromClients, kind::request(), &gateway_JobCancel_final_desc};
template <>
inline constexpr TopicInfo topic_info<gateway_GatewayStatus> = {"GatewayStatus", &gateway_GatewayStatus_desc,
                                                                kFromDaemon, kind::state(),
                                                                &gateway_GatewayStatus_final_desc};
template <>
inline constexpr TopicInfo topic_info<gateway_BusStatus> = {"BusStatus", &gateway_BusStatus_desc, kFromDaemon,
                                                            kind::state(), &gateway_BusStatus_final_desc};
template <>
inline constexpr TopicInfo topic_info<gateway_RealtimeStatus> = {
    "RealtimeStatus", &gateway_RealtimeStatus_desc, kFromDaemon, kind::state(),
    &gateway_RealtimeStatus_final_desc};
template <>
inline constexpr TopicInfo topic_info<gateway_Event> = {"Event", &gateway_Event_desc, kFromDaemon,
                                                        kind::events(), &gateway_Event_final_desc};

}  // namespace gateway::dds
