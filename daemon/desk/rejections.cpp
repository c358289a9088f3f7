#include "daemon/desk/rejections.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

namespace cansyncd {
namespace {

std::string_view name(Rejection kind) noexcept {
  switch (kind) {
    case Rejection::value:
      return "a field out of range";
    case Rejection::full:
      return "a limit reached";
    case Rejection::stale:
      return "too old or from the future";
    case Rejection::number:
      return "a number used before";
    case Rejection::identity:
      return "the identity of another program, or too many";
    case Rejection::malformed:
      return "malformed";
    case Rejection::other_daemon:
      return "meant for another start of a daemon, or for none";
    case Rejection::state:
      break;
  }
  return "not possible in this state";
}

}  // namespace

Rejection rejection_of(gateway_RefusalCause cause) noexcept {
  switch (cause) {
    case gateway_CAUSE_CLIENT_LIMIT:
    case gateway_CAUSE_SHARED_LIMIT:
      return Rejection::full;
    case gateway_CAUSE_STALE:
      return Rejection::stale;
    case gateway_CAUSE_NUMBER_USED:
      return Rejection::number;
    case gateway_CAUSE_IDENTITY:
      return Rejection::identity;
    case gateway_CAUSE_OTHER_DAEMON:
      return Rejection::other_daemon;
    case gateway_CAUSE_NOT_HELD:
    case gateway_CAUSE_READ_ONLY:
    case gateway_CAUSE_RIGHT:
    case gateway_CAUSE_WRONG_STATE:
    case gateway_CAUSE_SLAVE_LOST:
    case gateway_CAUSE_SLAVE_HELD:
    case gateway_CAUSE_SLAVES_MISSING:
    case gateway_CAUSE_BUS_UNAVAILABLE:
    case gateway_CAUSE_STOPPING:
    case gateway_CAUSE_MAPPING_CHANGED:
    case gateway_CAUSE_QUEUE_FULL:
      return Rejection::state;
    case gateway_CAUSE_NONE:
    case gateway_CAUSE_UNKNOWN:
    case gateway_CAUSE_FIELD:
    case gateway_CAUSE_SLAVE_NOT_CONFIGURED:
    case gateway_CAUSE_ELEMENT_NOT_WRITABLE:
    case gateway_CAUSE_VALUE_TOO_WIDE:
    case gateway_CAUSE_LENGTH:
    case gateway_CAUSE_BLOCK_SIZE:
    case gateway_CAUSE_ADDRESS:
    case gateway_CAUSE_ACTION_RESERVED:
    case gateway_CAUSE_NO_SLAVES:
    case gateway_CAUSE_MAPPING:
    case gateway_CAUSE_KIND:
    case gateway_CAUSE_UNKNOWN_JOB:
    case gateway_CAUSE_PROFILE:
      break;
  }
  return Rejection::value;
}

bool Rejections::line_allowed(SteadyTime now) {
  if (now - second_ >= std::chrono::seconds(1)) {
    second_ = now;
    lines_ = 0;
  }
  return lines_++ < kLines;
}

void Rejections::add(Rejection kind, const std::string& client, const std::string& text, SteadyTime now,
                     std::uint64_t count) {
  const auto index = static_cast<unsigned>(kind);
  counts_[index] += count;
  // Refusals for the state of the line are an everyday answer, and the reply tells.
  if (kind != Rejection::state && rows_[index].add(count, now)) {
    events_.publish(
        {gateway_SEVERITY_WARNING, "requests_rejected", -1, text, std::nullopt, std::nullopt, client}, now);
  } else if (line_allowed(now)) {
    events_.record(
        {gateway_SEVERITY_INFO, "requests_rejected", -1, text, std::nullopt, std::nullopt, client});
  }
}

std::optional<SteadyTime> Rejections::tick(SteadyTime now) {
  std::optional<SteadyTime> next;
  for (unsigned i = 0; i < kRejections; ++i) {
    if (const std::uint64_t count = rows_[i].take_over(now); count != 0) {
      events_.publish({gateway_SEVERITY_INFO, "requests_rejected_before", -1,
                       fmt::format("{} were rejected ({}); none for {} s", count,
                                   name(static_cast<Rejection>(i)), kQuiet.count()),
                       std::nullopt},
                      now);
    }
    const auto due = rows_[i].next();
    if (due && (!next || *due < *next)) next = due;
  }
  return next;
}

gateway::dds::Problem stale(std::int64_t written, std::int64_t now, std::chrono::milliseconds limit) {
  if (limit.count() == 0) return std::nullopt;
  constexpr std::int64_t kMillisecond = 1'000'000;
  // A time before 1970 is none; this keeps the difference in range.
  const std::int64_t age = (now - std::max<std::int64_t>(written, 0)) / kMillisecond;
  if (age > limit.count()) {
    return gateway::dds::Denial{
        gateway_CAUSE_STALE,
        fmt::format(
            "stale: written {} ms ago, at most {} ms are allowed (dds.request_max_age_ms); ask again, and set "
            "the clocks of both computers",
            age, limit.count())};
  }
  if (age < -limit.count()) {
    return gateway::dds::Denial{
        gateway_CAUSE_STALE,
        fmt::format(
            "from the future: written {} ms ahead, at most {} ms are allowed (dds.request_max_age_ms); set the "
            "clocks of both computers",
            -age, limit.count())};
  }
  return std::nullopt;
}

}  // namespace cansyncd
