#include "cansync_slave/dds/topics.h"

#include <array>

#include "dds/overview/overview_topics.h"

namespace cansync_slave::dds {

std::span<const TopicInfo* const> all_topics() noexcept {
  static constexpr auto kAll = std::to_array<const TopicInfo*>({
      &topic_info<cansync_slave_ReferencesReceived>,
      &topic_info<cansync_slave_MonitoredValues>,
      &topic_info<cansync_slave_ActualRelease>,
      &topic_info<cansync_slave_ActionReceived>,
      &topic_info<cansync_slave_ParameterJob>,
      &topic_info<cansync_slave_BlockJob>,
      &topic_info<cansync_slave_ApplicationAnswer>,
      &topic_info<cansync_slave_SlaveCommand>,
      &topic_info<cansync_slave_SlaveCommandReply>,
      &topic_info<cansync_slave_SlaveSideStatus>,
      &topic_info<gateway_JobCancel>,
      &topic_info<gateway_JobEnd>,
      &topic_info<gateway_JobEndReply>,
      &topic_info<gateway_OpenRequests>,
      &topic_info<gateway_GatewayStatus>,
      &topic_info<gateway_BusStatus>,
      &topic_info<gateway_RealtimeStatus>,
      &topic_info<gateway_Event>,
  });
  return kAll;
}

}  // namespace cansync_slave::dds
