#include "dds/writer_identity.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string_view>

#include "dds/entity.h"

namespace gateway::dds {
namespace {

constexpr std::size_t kLongestPart = 40;
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

/// Printable ASCII of what a peer says.
std::string clean(std::string_view text) {
  std::string out(text.substr(0, kLongestPart));
  std::replace_if(
      out.begin(), out.end(), [](unsigned char c) { return c < 0x20 || c > 0x7E; }, '?');
  return out;
}

/// The value of the property that is called so by Cyclone DDS, or by another implementation.
std::string property(const dds_qos_t* qos, const char* name, const char* other = nullptr) {
  char* value = nullptr;
  if ((!dds_qget_prop(qos, name, &value) || value == nullptr) &&
      (other == nullptr || !dds_qget_prop(qos, other, &value) || value == nullptr)) {
    return "";
  }
  const Memory<char> owned(value);
  return clean(value);
}

/// Name that the client's program gave itself.
std::string client_name(const dds_qos_t* qos) {
  void* value = nullptr;
  std::size_t size = 0;
  if (!dds_qget_userdata(qos, &value, &size) || value == nullptr) return "";
  const Memory<void> owned(value);
  return clean({static_cast<const char*>(value), size});
}

/// "lead_axis, process 1234 on host plc7"
std::string process_of(const Participant& participant, dds_instance_handle_t peer) {
  const Entity reader(
      dds_create_reader(participant.handle(), DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, nullptr, nullptr));
  if (!reader) return "";
  std::array<void*, 1> sample = {};
  std::array<dds_sample_info_t, 1> info;
  if (dds_read_instance(reader.get(), sample.data(), info.data(), 1, 1, peer) <= 0) return "";
  std::string text;
  if (info[0].valid_data) {
    const dds_qos_t* qos = static_cast<const dds_builtintopic_participant_t*>(sample[0])->qos;
    const std::string name = property(qos, "__ProcessName");
    const std::string process = property(qos, "__Pid", "fastdds.physical_data.process");
    const std::string host = property(qos, "__Hostname", "fastdds.physical_data.host");
    text = name;
    if (!process.empty()) text += fmt::format("{}process {}", text.empty() ? "" : ", ", process);
    if (!host.empty()) text += fmt::format("{}on host {}", text.empty() ? "" : " ", host);
  }
  (void)dds_return_loan(reader.get(), sample.data(), 1);
  return text;
}

}  // namespace

std::optional<WriterIdentity> identify_writer(const Participant& participant, dds_entity_t reader,
                                              dds_instance_handle_t writer) {
  const Endpoint endpoint(dds_get_matched_publication_data(reader, writer));
  if (!endpoint) return std::nullopt;
  WriterIdentity identity;
  (void)dds_qget_ownership_strength(endpoint->qos, &identity.strength);
  identity.who = program_of(participant, *endpoint);
  return identity;
}

std::string program_of(const Participant& participant, const dds_builtintopic_endpoint_t& endpoint) {
  std::string who;
  const std::string name = client_name(endpoint.qos);
  const std::string process = process_of(participant, endpoint.participant_instance_handle);
  if (!name.empty()) who = fmt::format("'{}'", name);
  if (!process.empty()) who += who.empty() ? process : fmt::format(" ({})", process);
  if (who.empty()) who = "an unknown program";
  if (who.size() > kLongest) who.resize(kLongest);
  return who;
}

}  // namespace gateway::dds
