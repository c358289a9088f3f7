#include "dds/ask/request_client.h"

#include <fmt/format.h>

#include "dds/reply_partition.h"
#include "dds/security.h"

namespace gateway::dds {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

Ended refused(gateway_RefusalCause cause, std::string reason) {
  return {true, gateway_REPLY_REFUSED, cause, std::move(reason)};
}

RequestClient::RequestClient(const ClientOptions& options)
    : options_(options),
      identity_(random_client_identity()),
      participant_(options.participant()),
      bus_reader_(participant_, &signal_),
      sight_(participant_, signal_, options.bus) {}

Partitions RequestClient::reply_partitions() const {
  return Partitions{reply_partition(participant_.options().partition, identity_)};
}

bool RequestClient::may_answer(const DaemonIdentity& daemon) {
  if (sight_.choice().may_answer(daemon)) return true;
  sight_.choice().program_told();
  return false;
}

const std::optional<gateway_BusStatus>& RequestClient::bus_status() {
  return bus_.take(bus_reader_);
}

std::optional<Ended> RequestClient::obstacle() {
  auto found = sight_.obstacle();
  if (!found) return std::nullopt;
  if (found->gone) return Ended{.reason = std::move(found->reason)};
  Ended ended = refused(gateway_CAUSE_OTHER_DAEMON, std::move(found->reason));
  ended.passes = found->passes;
  return ended;
}

std::optional<Ended> RequestClient::not_written(dds_return_t code, std::string_view topic,
                                                std::string_view role) {
  if (code == DDS_RETCODE_OK) return std::nullopt;
  if (code == DDS_RETCODE_NOT_ALLOWED_BY_SECURITY) return refused(gateway_CAUSE_RIGHT, no_right(topic, role));
  return refused(code == DDS_RETCODE_TIMEOUT ? gateway_CAUSE_SHARED_LIMIT : gateway_CAUSE_UNKNOWN,
                 fmt::format("the request could not be written: {}", dds_strretcode(code)));
}

std::optional<Ended> RequestClient::without_reply(std::uint64_t request, milliseconds longest,
                                                  Writer<gateway_JobCancel>& cancels,
                                                  const std::function<bool()>& came) {
  const auto daemon = sight_.choice().daemon();
  auto end = steady_clock::now() + longest;
  bool cancelled = false;
  while (!cancelled || steady_clock::now() < end) {
    sight_.look();
    if (came()) return std::nullopt;
    if (!may_answer(daemon)) return Ended{.reason = "the daemon has gone"};
    if (!cancelled && (options_.stopped() || steady_clock::now() >= end)) {
      cancelled = true;
      cancel(request, daemon, cancels);
      end = steady_clock::now() + kGrace;
    }
    (void)signal_.wait(DaemonSight::kLookMs);
    signal_.clear();
  }
  return Ended{.reason = "the daemon did not answer"};
}

void RequestClient::cancel(std::uint64_t request, const DaemonIdentity& daemon,
                           Writer<gateway_JobCancel>& cancels) {
  gateway_JobCancel sample = {};
  std::copy(identity_.begin(), identity_.end(), std::begin(sample.client));
  sample.request = request;
  set_daemon(daemon, sample);
  (void)cancels.write(sample);
}

}  // namespace gateway::dds
