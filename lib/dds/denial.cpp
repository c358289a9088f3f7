#include "dds/denial.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace gateway::dds {
namespace {

struct Word {
  gateway_RefusalCause cause;
  std::string_view word;
};

constexpr std::array<Word, kCauses> kWords = {{
    {gateway_CAUSE_NONE, "none"},
    {gateway_CAUSE_UNKNOWN, "unknown"},
    {gateway_CAUSE_FIELD, "field"},
    {gateway_CAUSE_SLAVE_NOT_CONFIGURED, "slave_not_configured"},
    {gateway_CAUSE_ELEMENT_NOT_WRITABLE, "element_not_writable"},
    {gateway_CAUSE_VALUE_TOO_WIDE, "value_too_wide"},
    {gateway_CAUSE_LENGTH, "length"},
    {gateway_CAUSE_BLOCK_SIZE, "block_size"},
    {gateway_CAUSE_ADDRESS, "address"},
    {gateway_CAUSE_ACTION_RESERVED, "action_reserved"},
    {gateway_CAUSE_NO_SLAVES, "no_slaves"},
    {gateway_CAUSE_MAPPING, "mapping"},
    {gateway_CAUSE_KIND, "kind"},
    {gateway_CAUSE_UNKNOWN_JOB, "unknown_job"},
    {gateway_CAUSE_NUMBER_USED, "number_used"},
    {gateway_CAUSE_IDENTITY, "identity"},
    {gateway_CAUSE_NOT_HELD, "not_held"},
    {gateway_CAUSE_PROFILE, "profile"},
    {gateway_CAUSE_READ_ONLY, "read_only"},
    {gateway_CAUSE_RIGHT, "right"},
    {gateway_CAUSE_WRONG_STATE, "wrong_state"},
    {gateway_CAUSE_SLAVE_LOST, "slave_lost"},
    {gateway_CAUSE_SLAVE_HELD, "slave_held"},
    {gateway_CAUSE_SLAVES_MISSING, "slaves_missing"},
    {gateway_CAUSE_BUS_UNAVAILABLE, "bus_unavailable"},
    {gateway_CAUSE_STOPPING, "stopping"},
    {gateway_CAUSE_OTHER_DAEMON, "other_daemon"},
    {gateway_CAUSE_MAPPING_CHANGED, "mapping_changed"},
    {gateway_CAUSE_STALE, "stale"},
    {gateway_CAUSE_QUEUE_FULL, "queue_full"},
    {gateway_CAUSE_CLIENT_LIMIT, "client_limit"},
    {gateway_CAUSE_SHARED_LIMIT, "shared_limit"},
}};

constexpr bool in_order() {
  for (std::size_t i = 0; i < kWords.size(); ++i)
    if (kWords[i].cause != i || kWords[i].word.empty()) return false;
  return true;
}
static_assert(in_order(), "a row for each cause, in the order of the data model");

}  // namespace

std::string_view name(gateway_RefusalCause cause) noexcept {
  std::uint32_t index = 0;  // a cause of a newer daemon is no value of the enumeration
  static_assert(sizeof cause == sizeof index);
  std::memcpy(&index, &cause, sizeof index);
  return kWords[index < kWords.size() ? index : std::size_t{gateway_CAUSE_UNKNOWN}].word;
}

std::string text_of(const Denial& denial) {
  return std::string(name(denial.cause)) + ": " + denial.reason;
}

}  // namespace gateway::dds
