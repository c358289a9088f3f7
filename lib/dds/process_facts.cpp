#include "dds/process_facts.h"

#include <dds/dds.h>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <iterator>
#include <memory>
#include <string_view>

#include "dds/entity.h"
#include "text/visible.h"

namespace gateway::dds {
namespace {

struct FreeProperty {
  void operator()(void* memory) const noexcept { dds_free(memory); }
};

/// The value of the property that is called so by Cyclone DDS, or by another implementation.
std::string told_property(const dds_qos_t* qos, const char* name, const char* other = nullptr) {
  char* value = nullptr;
  if ((!dds_qget_prop(qos, name, &value) || value == nullptr) &&
      (other == nullptr || !dds_qget_prop(qos, other, &value) || value == nullptr)) {
    return "";
  }
  const std::unique_ptr<char, FreeProperty> owned(value);
  return printable_part(value);
}

ProcessFacts facts_of(const dds_qos_t* qos) {
  ProcessFacts facts;
  facts.program = told_property(qos, "__ProcessName");
  const std::string process = told_property(qos, "__Pid", "fastdds.physical_data.process");
  (void)std::from_chars(process.data(), process.data() + process.size(), facts.process);
  // Fast DDS puts a number of its own behind the name.
  const std::string host = told_property(qos, "__Hostname", "fastdds.physical_data.host");
  facts.host = host.substr(0, host.find(':'));
  return facts;
}

}  // namespace

std::string printable_part(std::string_view text) {
  constexpr std::size_t kLongest = 40;
  return text::visible_ascii(text, kLongest);
}

ProcessFacts process_facts(const Participant& participant, const std::array<std::uint8_t, 16>& key) {
  const Entity reader(
      dds_create_reader(participant.handle(), DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, nullptr, nullptr));
  if (!reader) return {};
  dds_builtintopic_participant_t wanted = {};
  std::copy(key.begin(), key.end(), std::begin(wanted.key.v));
  const dds_instance_handle_t peer = dds_lookup_instance(reader.get(), &wanted);
  std::array<void*, 1> sample = {};
  std::array<dds_sample_info_t, 1> info;
  if (peer == 0 || dds_read_instance(reader.get(), sample.data(), info.data(), 1, 1, peer) <= 0) return {};
  ProcessFacts facts;
  if (info[0].valid_data)
    facts = facts_of(static_cast<const dds_builtintopic_participant_t*>(sample[0])->qos);
  (void)dds_return_loan(reader.get(), sample.data(), 1);
  return facts;
}

std::string text_of(const ProcessFacts& facts) {
  std::string text = facts.program;
  if (facts.process != 0) text += fmt::format("{}process {}", text.empty() ? "" : ", ", facts.process);
  if (!facts.host.empty()) text += fmt::format("{}on host {}", text.empty() ? "" : " ", facts.host);
  return text;
}

}  // namespace gateway::dds
