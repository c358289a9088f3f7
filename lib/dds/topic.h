#pragma once

#include <dds/dds.h>

#include <cstdint>
#include <memory>
#include <string_view>

/// What a topic is: name, type, who writes it, QoS. The topics themselves are declared by whoever has their
/// types (gateway_topics.h here, one table for each protocol).
namespace gateway::dds {

/// Most requests of all kinds that one client may have open. The daemon refuses more, the client library too.
inline constexpr std::uint32_t kOpenRequests = 64;

/// QoS of one topic, for its readers and writers alike unless said otherwise.
struct TopicQos {
  bool reliable = true;
  bool keep_all = false;         ///< true: requests and replies; false: keep last `depth`
  std::int32_t depth = 1;        ///< samples kept per key
  bool transient_local = false;  ///< late readers get the last `depth` samples
  /// One writer has it at a time, as the daemon decides by strength: automatic liveliness. Ownership is shared:
  /// with the exclusive one of DDS a reader would not see who waits, and of equal strengths GUIDs would decide.
  bool owned = false;
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

/// Who writes a topic.
inline constexpr bool kFromDaemon = true;
inline constexpr bool kFromClients = false;

/// One row of the table.
struct TopicInfo {
  std::string_view name;
  const dds_topic_descriptor_t* type;
  bool from_daemon;  ///< the daemon writes it; false: clients do
  TopicQos qos;
  /// The same struct without room for members to come, for a bus of final types; nullptr: has none.
  const dds_topic_descriptor_t* final_type = nullptr;
};

/// The row of an IDL type, beside its table; only topic types have one.
template <class T>
struct NotATopic;
template <class T>
inline constexpr TopicInfo topic_info = NotATopic<T>::none;

/// The row of the topic `Name` of the IDL module `module`. A macro: only so can the names that idlc makes be
/// put together, and no row can name two types.
#define GATEWAY_TOPIC(module, Name, from_daemon, qos)                                                    \
  template <>                                                                                            \
  inline constexpr TopicInfo topic_info<module##_##Name> = {#Name, &module##_##Name##_desc, from_daemon, \
                                                            qos, &module##_##Name##_final_desc}

/// QoS of the kinds of topics.
namespace kind {

/// What is: late readers get the last sample of each key.
constexpr TopicQos state() {
  return {.transient_local = true};
}

/// What only counts while it is new.
constexpr TopicQos latest() {
  return {.reliable = false};
}

/// What happened, the last 100 of each severity.
constexpr TopicQos events() {
  return {.depth = 100, .transient_local = true};
}

/// What one writer has at a time; a reader asks for signs of life at least every second. Values may be written
/// for intervals ahead, as many as the master keeps waiting.
constexpr TopicQos owned() {
  return {.depth = 16, .owned = true, .lease = DDS_SECS(1), .offered_lease = DDS_MSECS(500)};
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

}  // namespace kind

struct QosDeleter {
  void operator()(dds_qos_t* qos) const noexcept { dds_delete_qos(qos); }
};
using Qos = std::unique_ptr<dds_qos_t, QosDeleter>;

/// QoS for a reader of the topic.
Qos reader_qos(const TopicInfo& topic);
/// QoS for a writer of the topic; `strength` (0 and more): where one writer has it, a stronger one takes it over.
Qos writer_qos(const TopicInfo& topic, std::int32_t strength = 0);

}  // namespace gateway::dds
