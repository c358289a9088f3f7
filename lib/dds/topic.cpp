#include "dds/topic.h"

namespace gateway::dds {
namespace {

Qos common(const TopicQos& qos) {
  Qos out(dds_create_qos());
  dds_qset_reliability(out.get(), qos.reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                       qos.blocking);
  dds_qset_history(out.get(), qos.keep_all ? DDS_HISTORY_KEEP_ALL : DDS_HISTORY_KEEP_LAST, qos.depth);
  dds_qset_durability(out.get(),
                      qos.transient_local ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_ownership(out.get(), DDS_OWNERSHIP_SHARED);
  return out;
}

}  // namespace

Qos reader_qos(const TopicInfo& topic) {
  // Events have a writer for each level, and each of them gives a late reader its last ones.
  constexpr std::int32_t kWriters = 3;
  Qos qos = common(topic.qos);
  if (topic.qos.transient_local && topic.qos.depth > 1)
    dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, kWriters * topic.qos.depth);
  if (topic.qos.owned) dds_qset_liveliness(qos.get(), DDS_LIVELINESS_AUTOMATIC, topic.qos.lease);
  if (topic.qos.max_samples > 0) {
    dds_qset_resource_limits(qos.get(), topic.qos.max_samples, topic.qos.max_instances,
                             topic.qos.max_samples_per_instance);
  }
  return qos;
}

Qos writer_qos(const TopicInfo& topic, std::int32_t strength) {
  Qos qos = common(topic.qos);
  if (topic.qos.owned) {
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

}  // namespace gateway::dds
