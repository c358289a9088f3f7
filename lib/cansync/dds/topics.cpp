#include "cansync/dds/topics.h"

#include <array>

#include "dds/overview/overview_topics.h"

namespace cansync::dds {

bool for_engineers(cansync_CommandKind kind) noexcept {
  switch (kind) {
    case cansync_COMMAND_CONTROL_WORD:
    case cansync_COMMAND_BROADCAST:
      return false;
    case cansync_COMMAND_MODE:
    case cansync_COMMAND_POLLING:
    case cansync_COMMAND_CHANNEL_CURSORS:
    case cansync_COMMAND_REFERENCE_MAPPING:
    case cansync_COMMAND_ACTUAL_MAPPING:
    case cansync_COMMAND_RELEASE:
      break;
  }
  return true;
}

std::span<const TopicInfo* const> all_topics() noexcept {
  static constexpr std::array<const TopicInfo*, 23> kAll = {&topic_info<cansync_ActualValues>,
                                                            &topic_info<cansync_ReferenceValues>,
                                                            &topic_info<cansync_Interval>,
                                                            &topic_info<cansync_ParameterRequest>,
                                                            &topic_info<cansync_ParameterReply>,
                                                            &topic_info<cansync_TransferRequest>,
                                                            &topic_info<cansync_TransferProgress>,
                                                            &topic_info<cansync_TransferReply>,
                                                            &topic_info<gateway_JobCancel>,
                                                            &topic_info<gateway_JobEnd>,
                                                            &topic_info<gateway_JobEndReply>,
                                                            &topic_info<cansync_Command>,
                                                            &kEngineerCommandTopic,
                                                            &topic_info<cansync_CommandReply>,
                                                            &topic_info<cansync_MasterStatus>,
                                                            &topic_info<cansync_SlaveStatus>,
                                                            &topic_info<gateway_DriveProfile>,
                                                            &topic_info<cansync_Timing>,
                                                            &topic_info<gateway_OpenRequests>,
                                                            &topic_info<gateway_GatewayStatus>,
                                                            &topic_info<gateway_BusStatus>,
                                                            &topic_info<gateway_RealtimeStatus>,
                                                            &topic_info<gateway_Event>};
  return kAll;
}

}  // namespace cansync::dds
