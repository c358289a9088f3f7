#pragma once

#include <dds/dds.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "cansync.h"

/// The one table of topics: name, type and QoS. docs/dds-api.md shows the same table; a test compares both.
namespace cansync::dds {

/// Most requests of all kinds that one client may have open. The daemon refuses more, the client library too.
inline constexpr std::uint32_t kOpenRequests = 64;

/// QoS of one topic, for its readers and writers alike unless said otherwise.
struct TopicQos {
  bool reliable = true;
  bool keep_all = false;                        ///< true: requests and replies; false: keep last `depth`
  std::int32_t depth = 1;                       ///< samples kept per key
  bool transient_local = false;                 ///< late readers get the last `depth` samples
  bool exclusive = false;                       ///< exclusive ownership, automatic liveliness
  dds_duration_t lease = DDS_INFINITY;          ///< liveliness lease a reader asks for (ns)
  dds_duration_t offered_lease = DDS_INFINITY;  ///< liveliness lease our writers offer (ns)
  /// Keep all: most samples, keys and samples per key a reader holds until they are taken; a writer that
  /// finds them used up waits `blocking`. 0: no limit is needed.
  std::int32_t max_samples = 0;
  std::int32_t max_instances = 0;
  std::int32_t max_samples_per_instance = 0;
  /// Keep all: what a writer keeps of each key until readers have it, the newest alone beyond; a reader that
  /// stands still is then left behind and holds nobody up. 0: all, and the write waits.
  std::int32_t writer_depth = 0;
  dds_duration_t blocking = DDS_MSECS(100);  ///< longest a reliable write waits for room (ns)
};

/// One row of the table.
struct TopicInfo {
  std::string_view name;
  const dds_topic_descriptor_t* type;
  bool from_daemon;  ///< the daemon writes it; false: clients do
  TopicQos qos;
};

/// The row of an IDL type; only topic types have one.
template <class T>
const TopicInfo& topic_info() noexcept = delete;
template <>
const TopicInfo& topic_info<cansync_ActualValues>() noexcept;
template <>
const TopicInfo& topic_info<cansync_ReferenceValues>() noexcept;
template <>
const TopicInfo& topic_info<cansync_Interval>() noexcept;
template <>
const TopicInfo& topic_info<cansync_ParameterRequest>() noexcept;
template <>
const TopicInfo& topic_info<cansync_ParameterReply>() noexcept;
template <>
const TopicInfo& topic_info<cansync_TransferRequest>() noexcept;
template <>
const TopicInfo& topic_info<cansync_TransferProgress>() noexcept;
template <>
const TopicInfo& topic_info<cansync_TransferReply>() noexcept;
template <>
const TopicInfo& topic_info<cansync_JobCancel>() noexcept;
template <>
const TopicInfo& topic_info<cansync_Command>() noexcept;
template <>
const TopicInfo& topic_info<cansync_CommandReply>() noexcept;
template <>
const TopicInfo& topic_info<cansync_MasterStatus>() noexcept;
template <>
const TopicInfo& topic_info<cansync_SlaveStatus>() noexcept;
template <>
const TopicInfo& topic_info<cansync_Timing>() noexcept;
template <>
const TopicInfo& topic_info<cansync_Event>() noexcept;

/// Commands that only engineers may give, of the type of Command; used with DDS Security alone, whose
/// permissions are by topic.
const TopicInfo& engineer_command_topic() noexcept;

/// Does the command go over that topic when DDS Security is on? True also for kinds that are not known.
bool for_engineers(cansync_CommandKind kind) noexcept;

/// Every row, in the order of the IDL.
std::span<const TopicInfo* const> all_topics() noexcept;

struct QosDeleter {
  void operator()(dds_qos_t* qos) const noexcept { dds_delete_qos(qos); }
};
using Qos = std::unique_ptr<dds_qos_t, QosDeleter>;

/// QoS for a reader of the topic.
Qos reader_qos(const TopicInfo& topic);
/// QoS for a writer of the topic; `strength` (0 and more, the highest wins) counts with exclusive ownership.
Qos writer_qos(const TopicInfo& topic, std::int32_t strength = 0);

}  // namespace cansync::dds
