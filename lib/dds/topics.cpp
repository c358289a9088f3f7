#include "dds/topics.h"

#include <array>

namespace cansync::dds {
namespace {

constexpr TopicQos state() {
  return {.transient_local = true};
}

constexpr TopicQos latest() {
  return {.reliable = false};
}

constexpr TopicQos events() {
  return {.depth = 100, .transient_local = true};
}

/// Strongest living writer wins; a reader asks for signs of life at least every second. Values may be written
/// for intervals ahead, as many as the master keeps waiting.
constexpr TopicQos exclusive() {
  return {.depth = 16, .exclusive = true, .lease = DDS_SECS(1), .offered_lease = DDS_MSECS(500)};
}

/// No peer can make a reader grow without end. A client's samples have room for as many requests as it may
/// have open. There is more room than a KeyGuard lets in, for samples and keys, because those of writers that
/// have left are taken a little later: a reader that got full would hold up all topics.
constexpr TopicQos request() {
  constexpr auto kOpen = static_cast<std::int32_t>(kOpenRequests);
  return {.keep_all = true,
          .max_samples = 512 * kOpen,
          .max_instances = 512,
          .max_samples_per_instance = kOpen,
          .blocking = DDS_SECS(1)};
}

/// Replies go to every client of the bus, so a reader has room for those to the others too. Their writer
/// keeps `depth` of each client until every reader has them: a client that has `kOpenRequests` open
/// at most misses none. The daemon tries again soon: its thread has other things to do than to wait.
constexpr TopicQos reply(std::int32_t samples, std::int32_t depth) {
  return {.keep_all = true,
          .max_samples = samples,
          .max_instances = 1024,
          .max_samples_per_instance = samples,
          .writer_depth = depth,
          .blocking = DDS_MSECS(2)};
}

// One row a topic: name, type, who writes, QoS.
constexpr bool kDaemon = true;
constexpr bool kClient = false;
const TopicInfo kActualValues{"ActualValues", &cansync_ActualValues_desc, kDaemon, state()};
const TopicInfo kReferenceValues{"ReferenceValues", &cansync_ReferenceValues_desc, kClient, exclusive()};
const TopicInfo kInterval{"Interval", &cansync_Interval_desc, kDaemon, latest()};
const TopicInfo kParameterRequest{"ParameterRequest", &cansync_ParameterRequest_desc, kClient, request()};
const TopicInfo kParameterReply{"ParameterReply", &cansync_ParameterReply_desc, kDaemon, reply(4096, 2048)};
const TopicInfo kTransferRequest{"TransferRequest", &cansync_TransferRequest_desc, kClient, request()};
const TopicInfo kTransferProgress{"TransferProgress", &cansync_TransferProgress_desc, kDaemon, latest()};
const TopicInfo kTransferReply{"TransferReply", &cansync_TransferReply_desc, kDaemon, reply(16, 64)};
const TopicInfo kJobCancel{"JobCancel", &cansync_JobCancel_desc, kClient, request()};
const TopicInfo kCommand{"Command", &cansync_Command_desc, kClient, request()};
const TopicInfo kEngineerCommand{"EngineerCommand", &cansync_Command_desc, kClient, request()};
const TopicInfo kCommandReply{"CommandReply", &cansync_CommandReply_desc, kDaemon, reply(4096, 2048)};
const TopicInfo kMasterStatus{"MasterStatus", &cansync_MasterStatus_desc, kDaemon, state()};
const TopicInfo kSlaveStatus{"SlaveStatus", &cansync_SlaveStatus_desc, kDaemon, state()};
const TopicInfo kTiming{"Timing", &cansync_Timing_desc, kDaemon, latest()};
const TopicInfo kEvent{"Event", &cansync_Event_desc, kDaemon, events()};

Qos common(const TopicQos& qos) {
  Qos out(dds_create_qos());
  dds_qset_reliability(out.get(), qos.reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                       qos.blocking);
  dds_qset_history(out.get(), qos.keep_all ? DDS_HISTORY_KEEP_ALL : DDS_HISTORY_KEEP_LAST, qos.depth);
  dds_qset_durability(out.get(),
                      qos.transient_local ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_ownership(out.get(), qos.exclusive ? DDS_OWNERSHIP_EXCLUSIVE : DDS_OWNERSHIP_SHARED);
  return out;
}

}  // namespace

template <>
const TopicInfo& topic_info<cansync_ActualValues>() noexcept {
  return kActualValues;
}
template <>
const TopicInfo& topic_info<cansync_ReferenceValues>() noexcept {
  return kReferenceValues;
}
template <>
const TopicInfo& topic_info<cansync_Interval>() noexcept {
  return kInterval;
}
template <>
const TopicInfo& topic_info<cansync_ParameterRequest>() noexcept {
  return kParameterRequest;
}
template <>
const TopicInfo& topic_info<cansync_ParameterReply>() noexcept {
  return kParameterReply;
}
template <>
const TopicInfo& topic_info<cansync_TransferRequest>() noexcept {
  return kTransferRequest;
}
template <>
const TopicInfo& topic_info<cansync_TransferProgress>() noexcept {
  return kTransferProgress;
}
template <>
const TopicInfo& topic_info<cansync_TransferReply>() noexcept {
  return kTransferReply;
}
template <>
const TopicInfo& topic_info<cansync_JobCancel>() noexcept {
  return kJobCancel;
}
template <>
const TopicInfo& topic_info<cansync_Command>() noexcept {
  return kCommand;
}
template <>
const TopicInfo& topic_info<cansync_CommandReply>() noexcept {
  return kCommandReply;
}
template <>
const TopicInfo& topic_info<cansync_MasterStatus>() noexcept {
  return kMasterStatus;
}
template <>
const TopicInfo& topic_info<cansync_SlaveStatus>() noexcept {
  return kSlaveStatus;
}
template <>
const TopicInfo& topic_info<cansync_Timing>() noexcept {
  return kTiming;
}
template <>
const TopicInfo& topic_info<cansync_Event>() noexcept {
  return kEvent;
}

const TopicInfo& engineer_command_topic() noexcept {
  return kEngineerCommand;
}

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
  static constexpr std::array<const TopicInfo*, 16> kAll = {
      &kActualValues,   &kReferenceValues, &kInterval,         &kParameterRequest,
      &kParameterReply, &kTransferRequest, &kTransferProgress, &kTransferReply,
      &kJobCancel,      &kCommand,         &kEngineerCommand,  &kCommandReply,
      &kMasterStatus,   &kSlaveStatus,     &kTiming,           &kEvent};
  return kAll;
}

Qos reader_qos(const TopicInfo& topic) {
  Qos qos = common(topic.qos);
  if (topic.qos.exclusive) dds_qset_liveliness(qos.get(), DDS_LIVELINESS_AUTOMATIC, topic.qos.lease);
  if (topic.qos.max_samples > 0) {
    dds_qset_resource_limits(qos.get(), topic.qos.max_samples, topic.qos.max_instances,
                             topic.qos.max_samples_per_instance);
  }
  return qos;
}

Qos writer_qos(const TopicInfo& topic, std::int32_t strength) {
  Qos qos = common(topic.qos);
  if (topic.qos.exclusive) {
    dds_qset_liveliness(qos.get(), DDS_LIVELINESS_AUTOMATIC, topic.qos.offered_lease);
    dds_qset_ownership_strength(qos.get(), strength);
    // A writer that leaves gives its keys up; disposing of them would take them from the others too.
    dds_qset_writer_data_lifecycle(qos.get(), false);
  }
  if (topic.qos.writer_depth > 0) dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, topic.qos.writer_depth);
  // Giving up a key leaves nothing behind; disposing of it would make it anew in readers that never had it.
  if (topic.from_daemon && !topic.qos.transient_local) dds_qset_writer_data_lifecycle(qos.get(), false);
  if (topic.qos.transient_local) {
    dds_qset_durability_service(qos.get(), 0, DDS_HISTORY_KEEP_LAST, topic.qos.depth, DDS_LENGTH_UNLIMITED,
                                DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
  }
  return qos;
}

}  // namespace cansync::dds
