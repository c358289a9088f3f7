#include "client/src/causes.h"

#include <array>
#include <cstddef>

#include "dds/denial.h"

namespace cansync::client {
namespace {

struct CauseRow {
  gateway_RefusalCause number;
  RefusalCause cause;
  Retry retry;
};

/// The one table of what to do about a refusal; tests/dds/causes_check.py compares it with the data model.
constexpr std::array<CauseRow, gateway::dds::kCauses> kCauses = {{
    {gateway_CAUSE_NONE, RefusalCause::none, Retry::never},
    {gateway_CAUSE_UNKNOWN, RefusalCause::unknown, Retry::never},
    {gateway_CAUSE_FIELD, RefusalCause::field, Retry::never},
    {gateway_CAUSE_SLAVE_NOT_CONFIGURED, RefusalCause::slave_not_configured, Retry::never},
    {gateway_CAUSE_ELEMENT_NOT_WRITABLE, RefusalCause::element_not_writable, Retry::never},
    {gateway_CAUSE_VALUE_TOO_WIDE, RefusalCause::value_too_wide, Retry::never},
    {gateway_CAUSE_LENGTH, RefusalCause::length, Retry::never},
    {gateway_CAUSE_BLOCK_SIZE, RefusalCause::block_size, Retry::never},
    {gateway_CAUSE_ADDRESS, RefusalCause::address, Retry::never},
    {gateway_CAUSE_ACTION_RESERVED, RefusalCause::action_reserved, Retry::never},
    {gateway_CAUSE_NO_SLAVES, RefusalCause::no_slaves, Retry::never},
    {gateway_CAUSE_MAPPING, RefusalCause::mapping, Retry::never},
    {gateway_CAUSE_KIND, RefusalCause::kind, Retry::never},
    {gateway_CAUSE_UNKNOWN_JOB, RefusalCause::unknown_job, Retry::never},
    {gateway_CAUSE_NUMBER_USED, RefusalCause::number_used, Retry::never},
    {gateway_CAUSE_IDENTITY, RefusalCause::identity, Retry::never},
    {gateway_CAUSE_NOT_HELD, RefusalCause::not_held, Retry::never},
    {gateway_CAUSE_PROFILE, RefusalCause::profile, Retry::after_change},
    {gateway_CAUSE_READ_ONLY, RefusalCause::read_only, Retry::after_change},
    {gateway_CAUSE_RIGHT, RefusalCause::right, Retry::after_change},
    {gateway_CAUSE_WRONG_STATE, RefusalCause::wrong_state, Retry::when_state_over},
    {gateway_CAUSE_SLAVE_LOST, RefusalCause::slave_lost, Retry::when_state_over},
    {gateway_CAUSE_SLAVE_HELD, RefusalCause::slave_held, Retry::when_state_over},
    {gateway_CAUSE_SLAVES_MISSING, RefusalCause::slaves_missing, Retry::when_state_over},
    {gateway_CAUSE_BUS_UNAVAILABLE, RefusalCause::bus_unavailable, Retry::when_state_over},
    {gateway_CAUSE_STOPPING, RefusalCause::stopping, Retry::when_state_over},
    {gateway_CAUSE_OTHER_DAEMON, RefusalCause::other_daemon, Retry::soon},
    {gateway_CAUSE_MAPPING_CHANGED, RefusalCause::mapping_changed, Retry::soon},
    {gateway_CAUSE_STALE, RefusalCause::stale, Retry::soon},
    {gateway_CAUSE_QUEUE_FULL, RefusalCause::queue_full, Retry::soon},
    {gateway_CAUSE_CLIENT_LIMIT, RefusalCause::client_limit, Retry::soon},
    {gateway_CAUSE_SHARED_LIMIT, RefusalCause::shared_limit, Retry::soon},
}};

struct CodeRow {
  ReplyCode code;
  Retry retry;
};

/// Of every other end; a refusal is decided by its cause.
constexpr std::array kCodes = {
    CodeRow{ReplyCode::done, Retry::never},
    CodeRow{ReplyCode::refused, Retry::never},
    CodeRow{ReplyCode::slave_error, Retry::never},
    CodeRow{ReplyCode::timeout, Retry::look_first},
    CodeRow{ReplyCode::no_answer, Retry::look_first},
    CodeRow{ReplyCode::word_expected, Retry::never},
    CodeRow{ReplyCode::doubleword_expected, Retry::never},
    CodeRow{ReplyCode::value_too_wide, Retry::never},
    CodeRow{ReplyCode::cancelled, Retry::never},
    CodeRow{ReplyCode::master_stopped, Retry::look_first},
    CodeRow{ReplyCode::slave_lost, Retry::look_first},
    CodeRow{ReplyCode::no_reply, Retry::look_first},
    CodeRow{ReplyCode::replaced, Retry::never},
    CodeRow{ReplyCode::no_daemon, Retry::when_state_over},
};

constexpr bool in_order() {
  for (std::size_t i = 0; i < kCauses.size(); ++i)
    if (kCauses[i].number != i || static_cast<std::size_t>(kCauses[i].cause) != i) return false;
  for (std::size_t i = 0; i < kCodes.size(); ++i)
    if (static_cast<std::size_t>(kCodes[i].code) != i) return false;
  return true;
}
static_assert(in_order(), "a row for each number, in the order of the data model");

}  // namespace

RefusalCause detail::to_cause(gateway_RefusalCause cause) noexcept {
  const auto index = static_cast<std::size_t>(cause);
  return index < kCauses.size() ? kCauses[index].cause : RefusalCause::unknown;
}

RefusalCause detail::cause_of(const gateway::dds::Ended& not_begun) noexcept {
  return not_begun.replied ? to_cause(not_begun.cause) : RefusalCause::other_daemon;
}

std::string_view name(RefusalCause cause) noexcept {
  return gateway::dds::name(static_cast<gateway_RefusalCause>(cause));
}

std::string_view name(Retry retry) noexcept {
  switch (retry) {
    case Retry::after_change:
      return "after_change";
    case Retry::when_state_over:
      return "when_state_over";
    case Retry::soon:
      return "soon";
    case Retry::look_first:
      return "look_first";
    case Retry::never:
      break;
  }
  return "never";
}

Retry retry(ReplyCode code, RefusalCause cause) noexcept {
  if (code == ReplyCode::refused) {
    const auto index = static_cast<std::size_t>(cause);
    return index < kCauses.size() ? kCauses[index].retry : Retry::never;
  }
  const auto index = static_cast<std::size_t>(code);
  return index < kCodes.size() ? kCodes[index].retry : Retry::never;
}

}  // namespace cansync::client
