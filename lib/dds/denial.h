#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "dds/bounded_text.h"
#include "gateway.h"

/// Why requests are not taken, whatever their protocol: the one type that carries a refusal from where it is
/// decided to the reply.
namespace gateway::dds {

/// A request is not taken.
struct Denial {
  gateway_RefusalCause cause = gateway_CAUSE_UNKNOWN;  ///< for programs; never gateway_CAUSE_NONE
  std::string reason;  ///< for people: field, value and allowed range, or what is the case, and the remedy
};

/// Nothing, or why a request is not taken.
using Problem = std::optional<Denial>;

/// How many causes there are, gateway_CAUSE_NONE among them; they are numbered from 0.
inline constexpr unsigned kCauses = gateway_CAUSE_SHARED_LIMIT + 1u;

/// Stable word for a cause: its enumerator in small letters without CAUSE_, e.g. "slave_not_configured".
/// "unknown" for a number that is none.
std::string_view name(gateway_RefusalCause cause) noexcept;

/// "slave_not_configured: slave 9: not configured; allowed 0..3", for journal and events.
std::string text_of(const Denial& denial);

/// Does a reply with this code carry this cause? One with REPLY_REFUSED has one, every other has none.
constexpr bool fits(gateway_ReplyCode code, gateway_RefusalCause cause) noexcept {
  return (code == gateway_REPLY_REFUSED) == (cause != gateway_CAUSE_NONE);
}

/// Makes a reply of a refusal: its code, cause and reason.
template <class Reply>
void refuse(Reply& reply, const Denial& denial) noexcept {
  reply.code = gateway_REPLY_REFUSED;
  reply.cause = denial.cause;
  copy_text(denial.reason, reply.reason);
}

/// Sees to it that a reply is as `fits` wants it, whoever made it. False: it was not.
template <class Reply>
bool settle_cause(Reply& reply) noexcept {
  if (fits(reply.code, reply.cause)) return true;
  reply.cause = reply.code == gateway_REPLY_REFUSED ? gateway_CAUSE_UNKNOWN : gateway_CAUSE_NONE;
  return false;
}

}  // namespace gateway::dds
