#include "j1939/dds/topics.h"

#include <array>

#include "dds/overview/overview_topics.h"

namespace j1939::dds {

std::span<const TopicInfo* const> all_topics() noexcept {
  static constexpr std::array<const TopicInfo*, 15> kAll = {
      &topic_info<j1939_MessageBatch>,   &topic_info<j1939_LongMessage>,
      &topic_info<j1939_MessageRequest>, &topic_info<j1939_MessageReply>,
      &topic_info<gateway_JobCancel>,    &topic_info<gateway_JobEnd>,
      &topic_info<gateway_JobEndReply>,  &topic_info<gateway_OpenRequests>,
      &topic_info<j1939_NodeStatus>,     &topic_info<j1939_AddressTable>,
      &topic_info<j1939_FaultList>,      &topic_info<gateway_GatewayStatus>,
      &topic_info<gateway_BusStatus>,    &topic_info<gateway_RealtimeStatus>,
      &topic_info<gateway_Event>};
  return kAll;
}

}  // namespace j1939::dds
