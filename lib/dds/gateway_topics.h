#pragma once

#include "dds/topic.h"
#include "gateway.h"

/// Topics of gateway.idl.
namespace gateway::dds {

template <>
inline constexpr TopicInfo topic_info<gateway_JobCancel> = {"JobCancel", &gateway_JobCancel_desc,
                                                            kFromClients, kind::request()};
template <>
inline constexpr TopicInfo topic_info<gateway_Event> = {"Event", &gateway_Event_desc, kFromDaemon,
                                                        kind::events()};

}  // namespace gateway::dds
