#include "dds/overview/desk_client.h"

#include <algorithm>
#include <charconv>
#include <iterator>

#include "dds/bounded_text.h"
#include "dds/reply_partition.h"

namespace gateway::dds {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kForAReply{5000};
constexpr milliseconds kForAMatch{2000};

}  // namespace

DeskClient::Ends::Ends(const Participant& participant, DataSignal& signal, const std::string& bus,
                       const std::array<std::uint8_t, 16>& identity)
    : replies(participant, Partitions{reply_partition(bus, identity)}, &signal),
      requests(participant, 0, &signal) {}

DeskClient::DeskClient(const ClientOptions& options)
    : options_(options),
      identity_(random_client_identity()),
      participant_(options.participant()),
      sight_(participant_, signal_, options.bus),
      open_(participant_, &signal_) {
  dds_guid_t own = {};
  (void)dds_get_guid(participant_.handle(), &own);
  std::array<std::uint8_t, 16> key;
  std::copy(std::begin(own.v), std::end(own.v), key.begin());
  own_ = process_facts(participant_, key);
  sight_.find(
      options, signal_, "", {}, [] { return true; }, [] { return false; });
}

template <class Condition>
bool DeskClient::wait(milliseconds time, Condition&& condition) {
  const auto end = steady_clock::now() + time;
  while (!condition()) {
    if (options_.stopped() || steady_clock::now() >= end) return false;
    (void)signal_.wait(DaemonSight::kLookMs);
    signal_.clear();
    sight_.look();
  }
  return true;
}

std::optional<OpenRequestsNow> DeskClient::open(milliseconds time) {
  (void)wait(time, [this] { return open_.look().has_value(); });
  return open_.look();
}

bool DeskClient::wait_end(std::uint64_t job, milliseconds time) {
  return wait(time, [&] {
    const auto& now = open_.look();
    return now && std::none_of(now->requests.begin(), now->requests.end(),
                               [job](const gateway_OpenRequest& open) { return open.job == job; });
  });
}

std::string DeskClient::waits_behind(std::uint64_t request) {
  const auto& now = open_.look();
  if (!now) return "";
  const auto is_here = [&](const gateway_OpenRequest& open) {
    return std::any_of(now->programs.begin(), now->programs.end(), [&](const auto& program) {
      return std::equal(std::begin(program.participant), std::end(program.participant),
                        std::begin(open.participant)) &&
             program.process == own_.process && text(program.host) == own_.host;
    });
  };
  for (const gateway_OpenRequest& open : now->requests) {
    if (open.request == request && is_here(open)) return waited_for(*now, open);
  }
  return "";
}

std::optional<DeskClient::ProfileFile> DeskClient::profile(std::string_view hash, milliseconds time) {
  std::array<std::uint8_t, 32> wanted = {};
  if (hash.size() != 2 * wanted.size()) return std::nullopt;
  for (std::size_t i = 0; i < wanted.size(); ++i)
    (void)std::from_chars(hash.data() + 2 * i, hash.data() + 2 * i + 2, wanted.at(i), 16);
  Reader<gateway_DriveProfile> reader(participant_, &signal_);
  std::optional<ProfileFile> found;
  (void)wait(time, [&] {
    reader.take([&](const gateway_DriveProfile& sample) {
      if (!std::equal(wanted.begin(), wanted.end(), std::begin(sample.hash))) return;
      const auto* begin = sample.text._buffer;
      found = ProfileFile{sample.size, {begin, begin + sample.text._length}};
    });
    return found.has_value();
  });
  return found;
}

std::optional<DeskClient::Ended> DeskClient::take_reply(Ends& ends) const {
  std::optional<Ended> result;
  ends.replies.take([&](const gateway_JobEndReply& reply) {
    if (!std::equal(identity_.begin(), identity_.end(), std::begin(reply.client))) return;
    result =
        Ended{true, reply.code, reply.cause, std::string(text(reply.reason)), std::string(text(reply.ended))};
  });
  return result;
}

DeskClient::Ended DeskClient::end(std::uint64_t job) {
  Ends ends(participant_, signal_, options_.bus, identity_);
  const auto refused = [](gateway_RefusalCause cause, std::string reason) {
    return Ended{true, gateway_REPLY_REFUSED, cause, std::move(reason), ""};
  };
  const auto hindered = [this, &refused]() -> std::optional<Ended> {
    const auto obstacle = sight_.obstacle();
    if (!obstacle) return std::nullopt;
    if (obstacle->gone) return Ended{false, gateway_REPLY_DONE, gateway_CAUSE_NONE, obstacle->reason, ""};
    return refused(gateway_CAUSE_OTHER_DAEMON, obstacle->reason);
  };
  if (!ends.requests.permitted())
    return refused(gateway_CAUSE_RIGHT,
                   "the identity has no right to end requests of others, which engineers have; nothing was "
                   "sent");
  if (auto problem = hindered()) return *problem;
  if (!wait(kForAMatch, [&] { return sight_.is_read(ends.requests) && sight_.is_written(ends.replies); }))
    return refused(
        gateway_CAUSE_KIND,
        "the daemon does not take it: it is older than this program, or its bus takes no requests; "
        "nothing was sent");
  if (auto problem = hindered()) return *problem;
  gateway_JobEnd request = {};
  std::copy(identity_.begin(), identity_.end(), std::begin(request.client));
  request.request = 1;
  copy_text(options_.client_name, request.client_name);
  set_daemon(sight_.choice().daemon(), request);
  request.job = job;
  if (ends.requests.write(request) != DDS_RETCODE_OK)
    return refused(gateway_CAUSE_SHARED_LIMIT, "the request could not be written; try again");
  std::optional<Ended> result;
  (void)wait(kForAReply, [&] { return (result = take_reply(ends)).has_value(); });
  if (result) return *result;
  return {false, gateway_REPLY_DONE, gateway_CAUSE_NONE, "the daemon did not answer", ""};
}

}  // namespace gateway::dds
