#include "layer2/dds/topics.h"

#include <array>

#include "dds/overview/overview_topics.h"

namespace layer2::dds {

std::span<const TopicInfo* const> all_topics() noexcept {
  static constexpr std::array<const TopicInfo*, 22> kAll = {
      &topic_info<layer2_FrameBatch>,      &topic_info<layer2_SendRequest>,
      &topic_info<layer2_SendReply>,       &topic_info<layer2_ControlRequest>,
      &topic_info<layer2_ControlReply>,    &topic_info<layer2_ObjectRequest>,
      &topic_info<layer2_ObjectReply>,     &topic_info<gateway_JobCancel>,
      &topic_info<gateway_JobEnd>,         &topic_info<gateway_JobEndReply>,
      &topic_info<gateway_OpenRequests>,   &topic_info<layer2_ObjectStatus>,
      &topic_info<layer2_ModuleEvent>,     &topic_info<layer2_ImageOutputs>,
      &topic_info<layer2_RunLead>,         &topic_info<layer2_FrameStatus>,
      &topic_info<layer2_TimerStatus>,     &topic_info<layer2_ProcessImage>,
      &topic_info<gateway_GatewayStatus>,  &topic_info<gateway_BusStatus>,
      &topic_info<gateway_RealtimeStatus>, &topic_info<gateway_Event>};
  return kAll;
}

}  // namespace layer2::dds
