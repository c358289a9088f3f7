#include "dds/writer_identity.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <memory>
#include <string_view>
#include <vector>

#include "dds/process_facts.h"

namespace gateway::dds {
namespace {

constexpr std::size_t kLongest = 127;

struct EndpointDeleter {
  void operator()(dds_builtintopic_endpoint_t* endpoint) const noexcept {
    dds_builtintopic_free_endpoint(endpoint);
  }
};
using Endpoint = std::unique_ptr<dds_builtintopic_endpoint_t, EndpointDeleter>;

struct DdsFree {
  void operator()(void* memory) const noexcept { dds_free(memory); }
};
template <class T>
using Memory = std::unique_ptr<T, DdsFree>;

/// Name that the client's program gave itself.
std::string client_name(const dds_qos_t* qos) {
  void* value = nullptr;
  std::size_t size = 0;
  if (!dds_qget_userdata(qos, &value, &size) || value == nullptr) return "";
  const Memory<void> owned(value);
  return printable_part({static_cast<const char*>(value), size});
}

/// The participant of what Cyclone told of an endpoint, which is freed; 0: it told nothing.
dds_instance_handle_t participant_of(dds_builtintopic_endpoint_t* endpoint) {
  const Endpoint owned(endpoint);
  return owned ? owned->participant_instance_handle : 0;
}

/// Is one of the endpoints that are matched with `endpoint` of the participant? `list` and `data` are those
/// functions of Cyclone that name them and tell of one.
template <class List, class Data>
bool any_of_participant(dds_entity_t endpoint, dds_instance_handle_t participant, List list, Data data) {
  constexpr std::size_t kMost = 64;
  std::vector<dds_instance_handle_t> matched(kMost);
  const dds_return_t count = list(endpoint, matched.data(), matched.size());
  matched.resize(std::min(kMost, static_cast<std::size_t>(std::max(count, 0))));
  return std::any_of(matched.begin(), matched.end(), [&](dds_instance_handle_t one) {
    return participant_of(data(endpoint, one)) == participant;
  });
}

}  // namespace

std::optional<WriterIdentity> identify_writer(const Participant& participant, dds_entity_t reader,
                                              dds_instance_handle_t writer) {
  const Endpoint endpoint(dds_get_matched_publication_data(reader, writer));
  if (!endpoint) return std::nullopt;
  WriterIdentity identity;
  (void)dds_qget_ownership_strength(endpoint->qos, &identity.strength);
  std::copy(std::begin(endpoint->key.v), std::end(endpoint->key.v), identity.guid.begin());
  identity.who = program_of(participant, *endpoint);
  return identity;
}

std::string program_of(const Participant& participant, const dds_builtintopic_endpoint_t& endpoint) {
  std::string who;
  const std::string name = client_name(endpoint.qos);
  std::array<std::uint8_t, 16> key;
  std::copy(std::begin(endpoint.participant_key.v), std::end(endpoint.participant_key.v), key.begin());
  const std::string process = text_of(process_facts(participant, key));
  if (!name.empty()) who = fmt::format("'{}'", name);
  if (!process.empty()) who += who.empty() ? process : fmt::format(" ({})", process);
  if (who.empty()) who = "an unknown program";
  if (who.size() > kLongest) who.resize(kLongest);
  return who;
}

dds_instance_handle_t participant_of_writer(dds_entity_t reader, dds_instance_handle_t writer) {
  return participant_of(dds_get_matched_publication_data(reader, writer));
}

bool is_read_by(const WriterBase& writer, dds_instance_handle_t participant) {
  return any_of_participant(writer.handle(), participant, dds_get_matched_subscriptions,
                            dds_get_matched_subscription_data);
}

bool is_written_by(const ReaderBase& reader, dds_instance_handle_t participant) {
  return any_of_participant(reader.handle(), participant, dds_get_matched_publications,
                            dds_get_matched_publication_data);
}

}  // namespace gateway::dds
