#include "dds/endpoint.h"

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "dds/security.h"

namespace gateway::dds {
namespace {

constexpr const char* kRemedy =
    "look for programs with another version of the data model, or with less memory than they need, in this "
    "domain";

/// Cyclone would refuse it too, but would say so on standard error each time.
bool may_write(const Participant& participant, const TopicInfo& info) {
  const std::string& folder = participant.options().security;
  return folder.empty() || may_publish(folder, info.name);
}

Entity make_topic(const Participant& participant, const TopicInfo& info) {
  const std::string name(info.name);
  const dds_topic_descriptor_t* const type = participant.options().final_types ? info.final_type : info.type;
  const dds_entity_t topic =
      type == nullptr ? DDS_RETCODE_UNSUPPORTED
                      : dds_create_topic(participant.handle(), type, name.c_str(), nullptr, nullptr);
  if (topic < 0) participant.fail("topic " + name, topic, kRemedy);
  return Entity(topic);
}

/// Final types in the one representation that appendable types never have: no reader takes the one for the
/// other, whatever is known of types.
Qos represented(const Participant& participant, Qos qos) {
  constexpr dds_data_representation_id_t kRepresentation = DDS_DATA_REPRESENTATION_XCDR1;
  if (participant.options().final_types) dds_qset_data_representation(qos.get(), 1, &kRepresentation);
  return qos;
}

/// QoS of a publisher or subscriber in these partitions.
Qos partition_qos(const Partitions& partitions) {
  std::vector<const char*> names;
  for (const std::string& name : partitions) names.push_back(name.c_str());
  Qos qos(dds_create_qos());
  dds_qset_partition(qos.get(), static_cast<std::uint32_t>(names.size()), names.data());
  return qos;
}

}  // namespace

ReaderBase::ReaderBase(const Participant& participant, const TopicInfo& info, DataSignal* signal,
                       KeyGuard* guard, const Partitions& partitions)
    : EndpointBase(make_topic(participant, info), signal) {
  if (guard != nullptr) {
    const dds_return_t installed = guard->install(topic());
    if (installed != DDS_RETCODE_OK) {
      participant.fail("guard of topic " + std::string(info.name), installed, kRemedy);
    }
  }
  const Listener listener(dds_create_listener(matches()));
  dds_lset_subscription_matched(
      listener.get(),
      [](dds_entity_t /*reader*/, const dds_subscription_matched_status_t status, void* matches) {
        static_cast<Matches*>(matches)->count = status.current_count;
        static_cast<Matches*>(matches)->raise();
      });
  if (signal != nullptr) {
    dds_lset_data_available(listener.get(), [](dds_entity_t /*reader*/, void* matches) {
      static_cast<Matches*>(matches)->raise();
    });
    dds_lset_liveliness_changed(listener.get(),
                                [](dds_entity_t /*reader*/, const dds_liveliness_changed_status_t /*status*/,
                                   void* matches) { static_cast<Matches*>(matches)->raise(); });
  }
  Entity group;
  if (!partitions.empty()) {
    const dds_entity_t own =
        dds_create_subscriber(participant.handle(), partition_qos(partitions).get(), nullptr);
    if (own < 0) participant.fail("subscriber of topic " + std::string(info.name), own, kRemedy);
    group = Entity(own);
  }
  const dds_entity_t reader =
      dds_create_reader(group ? group.get() : participant.subscriber(), topic(),
                        represented(participant, reader_qos(info)).get(), listener.get());
  if (reader < 0) participant.fail("reader of topic " + std::string(info.name), reader, kRemedy);
  set_endpoint(Entity(reader), std::move(group));
}

WriterBase::WriterBase(const Participant& participant, const TopicInfo& info, std::int32_t strength,
                       DataSignal* signal, std::string_view name, const Partitions& partitions)
    : EndpointBase(may_write(participant, info) ? make_topic(participant, info) : Entity(), signal) {
  if (topic() <= 0) return;
  const Listener listener(dds_create_listener(matches()));
  dds_lset_publication_matched(
      listener.get(),
      [](dds_entity_t /*writer*/, const dds_publication_matched_status_t status, void* matches) {
        static_cast<Matches*>(matches)->count = status.current_count;
        static_cast<Matches*>(matches)->raise();
      });
  const Qos qos = represented(participant, writer_qos(info, strength));
  if (!name.empty()) dds_qset_userdata(qos.get(), name.data(), name.size());
  Entity group;
  if (!partitions.empty()) {
    const dds_entity_t own =
        dds_create_publisher(participant.handle(), partition_qos(partitions).get(), nullptr);
    if (own < 0) participant.fail("publisher of topic " + std::string(info.name), own, kRemedy);
    group = Entity(own);
  }
  const dds_entity_t writer =
      dds_create_writer(group ? group.get() : participant.publisher(), topic(), qos.get(), listener.get());
  if (writer < 0) participant.fail("writer of topic " + std::string(info.name), writer, kRemedy);
  set_endpoint(Entity(writer), std::move(group));
}

}  // namespace gateway::dds
