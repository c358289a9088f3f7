#include "dds/incompatible.h"

#include <dds/dds.h>
#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <iterator>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "dds/entity.h"
#include "dds/topic.h"
#include "dds/writer_identity.h"

namespace gateway::dds {
namespace {

/// Endpoints of a domain that are looked at; nobody has more.
constexpr std::size_t kMostEndpoints = 16384;
constexpr std::size_t kMostMatched = 4096;
constexpr std::size_t kLongestName = 128;

/// What is wrong between a reader and a writer.
struct Difference {
  std::string_view policy;
  std::string words;
};

struct FreeRepresentations {
  void operator()(void* memory) const noexcept { dds_free(memory); }
};

/// The participant's endpoints of one topic and kind.
struct Own {
  std::string topic;
  std::string type;
  Qos qos;
  std::vector<std::string> partitions;
  std::vector<dds_instance_handle_t> matched;  ///< sorted
};

std::string_view word(dds_data_representation_id_t representation) noexcept {
  if (representation == DDS_DATA_REPRESENTATION_XCDR1) return "XCDR1";
  return representation == DDS_DATA_REPRESENTATION_XCDR2 ? "XCDR2" : "another";
}

std::string time_text(dds_duration_t time) {
  return time == DDS_INFINITY ? "infinite" : fmt::format("{} ms", time / DDS_NSECS_IN_MSEC);
}

/// What an endpoint writes or reads, the one it prefers first. Who does not tell has XCDR1.
std::vector<dds_data_representation_id_t> representations(const dds_qos_t* qos) {
  std::uint32_t count = 0;
  dds_data_representation_id_t* values = nullptr;
  if (!dds_qget_data_representation(qos, &count, &values) || count == 0)
    return {DDS_DATA_REPRESENTATION_XCDR1};
  const std::unique_ptr<dds_data_representation_id_t, FreeRepresentations> owned(values);
  return {values, values + count};
}

std::optional<Difference> representation_difference(const dds_qos_t* reader, const dds_qos_t* writer) {
  const auto offered = representations(writer).front();
  const auto asked = representations(reader);
  if (std::find(asked.begin(), asked.end(), offered) != asked.end()) return std::nullopt;
  return Difference{"data representation",
                    fmt::format("offered {}, asked for {}", word(offered), word(asked.front()))};
}

std::optional<Difference> liveliness_difference(const dds_qos_t* reader, const dds_qos_t* writer) {
  dds_liveliness_kind_t asked = DDS_LIVELINESS_AUTOMATIC;
  dds_liveliness_kind_t offered = DDS_LIVELINESS_AUTOMATIC;
  dds_duration_t asked_lease = DDS_INFINITY;
  dds_duration_t offered_lease = DDS_INFINITY;
  (void)dds_qget_liveliness(reader, &asked, &asked_lease);
  (void)dds_qget_liveliness(writer, &offered, &offered_lease);
  if (asked > offered) return Difference{"liveliness", "another kind"};
  if (asked_lease >= offered_lease) return std::nullopt;
  return Difference{"liveliness", fmt::format("lease offered {}, asked for {}", time_text(offered_lease),
                                              time_text(asked_lease))};
}

std::optional<Difference> order_difference(const dds_qos_t* reader, const dds_qos_t* writer) {
  dds_presentation_access_scope_kind_t asked = DDS_PRESENTATION_INSTANCE;
  dds_presentation_access_scope_kind_t offered = DDS_PRESENTATION_INSTANCE;
  std::array<bool, 2> asks = {};
  std::array<bool, 2> offers = {};
  (void)dds_qget_presentation(reader, &asked, &asks[0], &asks[1]);
  (void)dds_qget_presentation(writer, &offered, &offers[0], &offers[1]);
  if (asked > offered || asks[0] > offers[0] || asks[1] > offers[1]) return Difference{"presentation", ""};
  dds_destination_order_kind_t asked_order = DDS_DESTINATIONORDER_BY_RECEPTION_TIMESTAMP;
  dds_destination_order_kind_t offered_order = DDS_DESTINATIONORDER_BY_RECEPTION_TIMESTAMP;
  (void)dds_qget_destination_order(reader, &asked_order);
  (void)dds_qget_destination_order(writer, &offered_order);
  if (asked_order > offered_order) return Difference{"destination order", ""};
  return std::nullopt;
}

std::optional<Difference> time_difference(const dds_qos_t* reader, const dds_qos_t* writer) {
  dds_duration_t asked = DDS_INFINITY;
  dds_duration_t offered = DDS_INFINITY;
  (void)dds_qget_deadline(reader, &asked);
  (void)dds_qget_deadline(writer, &offered);
  if (asked < offered)
    return Difference{"deadline",
                      fmt::format("offered {}, asked for {}", time_text(offered), time_text(asked))};
  asked = offered = 0;
  (void)dds_qget_latency_budget(reader, &asked);
  (void)dds_qget_latency_budget(writer, &offered);
  if (asked < offered) return Difference{"latency budget", ""};
  return std::nullopt;
}

/// The first policy by which the reader asks for more than the writer offers, as DDS compares them.
std::optional<Difference> qos_difference(const dds_qos_t* reader, const dds_qos_t* writer) {
  dds_reliability_kind_t asked = DDS_RELIABILITY_BEST_EFFORT;
  dds_reliability_kind_t offered = DDS_RELIABILITY_BEST_EFFORT;
  dds_duration_t blocking = 0;
  (void)dds_qget_reliability(reader, &asked, &blocking);
  (void)dds_qget_reliability(writer, &offered, &blocking);
  if (asked > offered) return Difference{"reliability", "offered best effort, asked for reliable"};
  dds_durability_kind_t asked_durability = DDS_DURABILITY_VOLATILE;
  dds_durability_kind_t offered_durability = DDS_DURABILITY_VOLATILE;
  (void)dds_qget_durability(reader, &asked_durability);
  (void)dds_qget_durability(writer, &offered_durability);
  if (asked_durability > offered_durability)
    return Difference{"durability", "less is offered than is asked for"};
  dds_ownership_kind_t asked_ownership = DDS_OWNERSHIP_SHARED;
  dds_ownership_kind_t offered_ownership = DDS_OWNERSHIP_SHARED;
  (void)dds_qget_ownership(reader, &asked_ownership);
  (void)dds_qget_ownership(writer, &offered_ownership);
  if (asked_ownership != offered_ownership) {
    const bool exclusive = asked_ownership == DDS_OWNERSHIP_EXCLUSIVE;
    return Difference{"ownership", exclusive ? "offered shared, asked for exclusive"
                                             : "offered exclusive, asked for shared"};
  }
  if (auto found = liveliness_difference(reader, writer)) return found;
  if (auto found = representation_difference(reader, writer)) return found;
  if (auto found = order_difference(reader, writer)) return found;
  return time_difference(reader, writer);
}

using PartitionNames = std::vector<std::string>;

/// As DDS has it, none is the one without a name.
PartitionNames partitions_of(const dds_qos_t* qos) {
  std::uint32_t count = 0;
  char** names = nullptr;
  if (!dds_qget_partition(qos, &count, &names) || count == 0) return {""};
  PartitionNames found;
  for (char* name : std::span(names, count)) {
    found.emplace_back(name);
    dds_free(name);
  }
  dds_free(names);
  return found;
}

bool overlap(const PartitionNames& one, const PartitionNames& other) {
  const auto is_pattern = [](const std::string& name) {
    return name.find_first_of("*?") != std::string::npos;
  };
  const auto fits = [&](const std::string& a, const std::string& b) {
    if (is_pattern(a) && is_pattern(b)) return false;  // DDS 1.4, 2.2.3.13
    return fnmatch(a.c_str(), b.c_str(), 0) == 0 || fnmatch(b.c_str(), a.c_str(), 0) == 0;
  };
  return std::any_of(one.begin(), one.end(), [&](const std::string& a) {
    return std::any_of(other.begin(), other.end(), [&](const std::string& b) { return fits(a, b); });
  });
}

std::vector<dds_entity_t> children_of(dds_entity_t parent) {
  const dds_return_t count = dds_get_children(parent, nullptr, 0);
  std::vector<dds_entity_t> children(static_cast<std::size_t>(std::max(count, 0)));
  const dds_return_t got = dds_get_children(parent, children.data(), children.size());
  children.resize(std::min(children.size(), static_cast<std::size_t>(std::max(got, 0))));
  return children;
}

/// Adds the writers (`writers`) or readers below a publisher or subscriber in a partition of the bus.
void add_endpoints(dds_entity_t parent, const std::string& bus, bool writers, std::vector<Own>& found) {
  const Qos group(dds_create_qos());
  if (dds_get_qos(parent, group.get()) < 0) return;
  const PartitionNames partitions = partitions_of(group.get());
  const auto of_bus = [&](const std::string& name) { return name == bus || name.starts_with(bus + '/'); };
  if (std::none_of(partitions.begin(), partitions.end(), of_bus)) return;
  for (const dds_entity_t child : children_of(parent)) {
    std::array<char, kLongestName> name = {};
    std::array<char, kLongestName> type = {};
    const dds_entity_t topic = dds_get_topic(child);
    Qos qos(dds_create_qos());
    if ((writers ? dds_get_publisher(child) : dds_get_subscriber(child)) < 0 ||
        dds_get_name(topic, name.data(), name.size()) < 0 ||
        dds_get_type_name(topic, type.data(), type.size()) < 0 || dds_get_qos(child, qos.get()) < 0) {
      continue;
    }
    std::vector<dds_instance_handle_t> matched(kMostMatched);
    const dds_return_t others = writers ? dds_get_matched_subscriptions(child, matched.data(), matched.size())
                                        : dds_get_matched_publications(child, matched.data(), matched.size());
    matched.resize(std::min(matched.size(), static_cast<std::size_t>(std::max(others, 0))));
    const auto known =
        std::find_if(found.begin(), found.end(), [&](const Own& own) { return own.topic == name.data(); });
    if (known == found.end()) {
      found.push_back({name.data(), type.data(), std::move(qos), partitions, std::move(matched)});
    } else {
      known->partitions.insert(known->partitions.end(), partitions.begin(), partitions.end());
      known->matched.insert(known->matched.end(), matched.begin(), matched.end());
    }
  }
}

/// The writers (`writers`) or readers of one bus; others share its DDS participant.
std::vector<Own> endpoints_of(const Participant& participant, bool writers) {
  std::vector<Own> found;
  for (const dds_entity_t group : children_of(participant.handle()))
    add_endpoints(group, participant.options().partition, writers, found);
  for (Own& own : found) std::sort(own.matched.begin(), own.matched.end());
  return found;
}

/// One look through the domain's writers or readers.
class Look {
 public:
  Look(const Participant& participant, bool types, std::size_t most)
      : participant_(participant), types_(types), most_(most) {
    (void)dds_get_guid(participant.handle(), &self_);
  }

  /// Writers of others against our readers, or readers of others against our writers.
  void look(bool writers) {
    const std::vector<Own> own = endpoints_of(participant_, !writers);
    const Entity reader(dds_create_reader(
        participant_.handle(),
        writers ? DDS_BUILTIN_TOPIC_DCPSPUBLICATION : DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION, nullptr, nullptr));
    if (!reader) return;
    constexpr std::size_t kBatch = 256;
    for (std::size_t seen = 0; seen < kMostEndpoints && found_.size() < most_;) {
      std::array<void*, kBatch> samples = {};
      std::array<dds_sample_info_t, kBatch> infos;
      const dds_return_t count = dds_take(reader.get(), samples.data(), infos.data(), kBatch, kBatch);
      if (count <= 0) return;
      for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
        if (!infos[i].valid_data || infos[i].instance_state != DDS_IST_ALIVE) continue;
        compare(own, *static_cast<const dds_builtintopic_endpoint_t*>(samples[i]), infos[i].instance_handle,
                writers);
      }
      seen += static_cast<std::size_t>(count);
      (void)dds_return_loan(reader.get(), samples.data(), count);
    }
  }

  std::vector<Incompatible> take() { return std::move(found_); }

 private:
  void compare(const std::vector<Own>& all, const dds_builtintopic_endpoint_t& other,
               dds_instance_handle_t handle, bool writes) {
    if (found_.size() >= most_ || std::memcmp(&other.participant_key, &self_, sizeof self_) == 0) return;
    const auto own = std::find_if(all.begin(), all.end(),
                                  [&](const Own& candidate) { return candidate.topic == other.topic_name; });
    if (own == all.end() || std::binary_search(own->matched.begin(), own->matched.end(), handle)) return;
    const PartitionNames partitions = partitions_of(other.qos);
    const bool meet = overlap(own->partitions, partitions);
    if (!meet && !overlap({participant_.options().partition}, partitions)) return;
    const dds_qos_t* reader = writes ? own->qos.get() : other.qos;
    const dds_qos_t* writer = writes ? other.qos : own->qos.get();
    std::optional<Difference> difference = qos_difference(reader, writer);
    if (!difference && !meet) {
      // Of ours that for all clients, not those for one.
      const std::string& ours = *std::min_element(
          own->partitions.begin(), own->partitions.end(),
          [](const std::string& one, const std::string& two) { return one.size() < two.size(); });
      const std::string& offered = writes ? partitions.front() : ours;
      const std::string& asked = writes ? ours : partitions.front();
      difference = Difference{"partition", fmt::format("offered {}, asked for {}", offered, asked)};
    }
    if (!difference && own->type != other.type_name) difference = Difference{"type", "another name"};
    if (!difference && types_) difference = Difference{"type", "other members"};
    if (!difference) return;
    std::string digits;
    for (const unsigned byte : other.participant_key.v) digits += fmt::format("{:02x}", byte);
    found_.push_back({own->topic, writes, std::string(difference->policy), std::move(difference->words),
                      program_of(participant_, other), std::move(digits)});
  }

  const Participant& participant_;
  bool types_;
  std::size_t most_;
  dds_guid_t self_ = {};
  std::vector<Incompatible> found_;
};

}  // namespace

std::vector<Incompatible> find_incompatible(const Participant& participant, bool types, std::size_t most) {
  Look look(participant, types, most);
  look.look(true);
  look.look(false);
  return look.take();
}

std::string to_string(const Incompatible& endpoint) {
  return fmt::format("a {} of topic {} of {} does not match: {}{}", endpoint.writes ? "writer" : "reader",
                     endpoint.topic, endpoint.who, endpoint.policy,
                     endpoint.difference.empty() ? "" : fmt::format(" ({})", endpoint.difference));
}

}  // namespace gateway::dds
