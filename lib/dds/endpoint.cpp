#include "dds/endpoint.h"

#include <algorithm>
#include <list>
#include <memory>
#include <optional>
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

/// Samples of a writer that late readers get, read while it lives.
class Told {
 public:
  /// `writer`: of transient local durability. Without the right to read the topic, there are none.
  explicit Told(dds_entity_t writer) {
    const Qos group(dds_create_qos());
    const Qos qos(dds_create_qos());
    if (dds_get_qos(dds_get_publisher(writer), group.get()) < 0 || dds_get_qos(writer, qos.get()) < 0) return;
    subscriber_ = Entity(dds_create_subscriber(dds_get_participant(writer), group.get(), nullptr));
    if (!subscriber_) return;
    reader_ = Entity(dds_create_reader(subscriber_.get(), dds_get_topic(writer), qos.get(), nullptr));
    if (!reader_) return;
    samples_.resize(kMost);
    infos_.resize(kMost);
    count_ = dds_take(reader_.get(), samples_.data(), infos_.data(), kMost, kMost);
  }
  ~Told() {
    if (count_ > 0) (void)dds_return_loan(reader_.get(), samples_.data(), count_);
  }
  Told(const Told&) = delete;
  Told& operator=(const Told&) = delete;

  /// Tells them again, with their times.
  void tell(dds_entity_t writer) const {
    for (std::size_t i = 0; i < static_cast<std::size_t>(std::max(count_, 0)); ++i) {
      if (infos_[i].valid_data) (void)dds_write_ts(writer, samples_[i], infos_[i].source_timestamp);
    }
  }

 private:
  static constexpr std::uint32_t kMost = 1024;  ///< more than one of our writers keeps

  Entity subscriber_;
  Entity reader_;
  std::vector<void*> samples_;
  std::vector<dds_sample_info_t> infos_;
  dds_return_t count_ = 0;
};

/// Is it a writer whose samples late readers get?
bool tells_late_readers(dds_entity_t endpoint) {
  const Qos qos(dds_create_qos());
  dds_durability_kind_t durability = DDS_DURABILITY_VOLATILE;
  return dds_get_publisher(endpoint) > 0 && dds_get_qos(endpoint, qos.get()) >= 0 &&
         dds_qget_durability(qos.get(), &durability) && durability == DDS_DURABILITY_TRANSIENT_LOCAL;
}

}  // namespace

EndpointBase::EndpointBase(const Participant& participant, DataSignal* signal, Make make)
    : made_(std::make_unique<Made>(participant, signal, std::move(make))) {}

EndpointBase::Made::Made(const Participant& participant, DataSignal* signal, Make make)
    : make_(std::move(make)), movables_(participant.movables()) {
  matches.signal = signal;
  entities = make_(participant, matches);
  movables_->add(*this);
}

EndpointBase::Made::~Made() {
  movables_->remove(*this);
}

void EndpointBase::Made::move_to(const Participant& participant, std::list<Entity>& left) {
  std::optional<Told> told;
  const dds_entity_t before = entities.endpoint.get();
  if (tells_late_readers(before)) told.emplace(before);
  if (dds_get_publisher(before) > 0) {
    // It writes nothing more, and what its listener knows is over.
    (void)dds_set_listener(before, nullptr);
    left.push_back(std::move(entities.endpoint));
    left.push_back(std::move(entities.group));
    left.push_back(std::move(entities.topic));
  } else {
    // At once: its guard is to guard the next one alone.
    entities.endpoint.reset();
    entities.group.reset();
    entities.topic.reset();
  }
  matches.count = 0;
  entities = make_(participant, matches);
  if (told) told->tell(entities.endpoint.get());
  matches.raise();
}

ReaderBase::ReaderBase(const Participant& participant, const TopicInfo& info, DataSignal* signal,
                       TopicGuard* guard, const Partitions& partitions)
    : EndpointBase(participant, signal, [info, guard, partitions](const Participant& at, Matches& matches) {
        return make_reader(at, info, guard, partitions, matches);
      }) {}

ReaderBase::Entities ReaderBase::make_reader(const Participant& participant, const TopicInfo& info,
                                             TopicGuard* guard, const Partitions& partitions,
                                             Matches& matches) {
  Entities made;
  made.topic = make_topic(participant, info);
  if (guard != nullptr) {
    const dds_return_t installed = guard->install(made.topic.get());
    if (installed != DDS_RETCODE_OK) {
      participant.fail("guard of topic " + std::string(info.name), installed, kRemedy);
    }
  }
  const Listener listener(dds_create_listener(&matches));
  dds_lset_subscription_matched(
      listener.get(), [](dds_entity_t /*reader*/, const dds_subscription_matched_status_t status, void* to) {
        static_cast<Matches*>(to)->count = status.current_count;
        static_cast<Matches*>(to)->raise();
      });
  if (matches.signal != nullptr) {
    dds_lset_data_available(listener.get(),
                            [](dds_entity_t /*reader*/, void* to) { static_cast<Matches*>(to)->raise(); });
    dds_lset_liveliness_changed(listener.get(),
                                [](dds_entity_t /*reader*/, const dds_liveliness_changed_status_t /*status*/,
                                   void* to) { static_cast<Matches*>(to)->raise(); });
  }
  if (!partitions.empty()) {
    const dds_entity_t own =
        dds_create_subscriber(participant.handle(), partition_qos(partitions).get(), nullptr);
    if (own < 0) participant.fail("subscriber of topic " + std::string(info.name), own, kRemedy);
    made.group = Entity(own);
  }
  const dds_entity_t reader =
      dds_create_reader(made.group ? made.group.get() : participant.subscriber(), made.topic.get(),
                        represented(participant, reader_qos(info)).get(), listener.get());
  if (reader < 0) participant.fail("reader of topic " + std::string(info.name), reader, kRemedy);
  made.endpoint = Entity(reader);
  return made;
}

WriterBase::WriterBase(const Participant& participant, const TopicInfo& info, std::int32_t strength,
                       DataSignal* signal, std::string_view name, const Partitions& partitions)
    : EndpointBase(
          participant, signal,
          [info, strength, name = std::string(name), partitions](const Participant& at, Matches& matches) {
            return make_writer(at, info, strength, name, partitions, matches);
          }) {}

WriterBase::Entities WriterBase::make_writer(const Participant& participant, const TopicInfo& info,
                                             std::int32_t strength, const std::string& name,
                                             const Partitions& partitions, Matches& matches) {
  Entities made;
  if (!may_write(participant, info)) return made;
  made.topic = make_topic(participant, info);
  const Listener listener(dds_create_listener(&matches));
  dds_lset_publication_matched(
      listener.get(), [](dds_entity_t /*writer*/, const dds_publication_matched_status_t status, void* to) {
        static_cast<Matches*>(to)->count = status.current_count;
        static_cast<Matches*>(to)->raise();
      });
  const Qos qos = represented(participant, writer_qos(info, strength));
  if (!name.empty()) dds_qset_userdata(qos.get(), name.data(), name.size());
  if (!partitions.empty()) {
    const dds_entity_t own =
        dds_create_publisher(participant.handle(), partition_qos(partitions).get(), nullptr);
    if (own < 0) participant.fail("publisher of topic " + std::string(info.name), own, kRemedy);
    made.group = Entity(own);
  }
  const dds_entity_t writer = dds_create_writer(made.group ? made.group.get() : participant.publisher(),
                                                made.topic.get(), qos.get(), listener.get());
  if (writer < 0) participant.fail("writer of topic " + std::string(info.name), writer, kRemedy);
  made.endpoint = Entity(writer);
  return made;
}

}  // namespace gateway::dds
