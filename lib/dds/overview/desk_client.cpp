#include "dds/overview/desk_client.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <iterator>

#include "dds/bounded_text.h"

namespace gateway::dds {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kForAReply{5000};
constexpr milliseconds kForAMatch{2000};

}  // namespace

DeskClient::DeskClient(const ClientOptions& options)
    : RequestClient(options), open_(participant(), &signal()) {
  dds_guid_t own = {};
  (void)dds_get_guid(participant().handle(), &own);
  std::array<std::uint8_t, 16> key;
  std::copy(std::begin(own.v), std::end(own.v), key.begin());
  own_ = process_facts(participant(), key);
  connect(
      "", nullptr, {}, [] { return true; }, [] { return false; });
}

template <class Condition>
bool DeskClient::wait(milliseconds time, Condition&& condition) {
  const auto end = steady_clock::now() + time;
  while (!condition()) {
    if (stopped() || steady_clock::now() >= end) return false;
    (void)signal().wait(DaemonSight::kLookMs);
    signal().clear();
    sight().look();
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
  Reader<gateway_DriveProfile> reader(participant(), &signal());
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

namespace {

/// The program does not wait any longer.
DeskClient::EndedOther cancelled(std::string reason) {
  return {{.replied = true, .code = gateway_REPLY_CANCELLED, .reason = std::move(reason)}};
}

}  // namespace

DeskClient::EndedOther DeskClient::end(std::uint64_t job) {
  Reader<gateway_JobEndReply> replies(participant(), reply_partitions(), &signal());
  Writer<gateway_JobEnd> requests(participant(), 0, &signal());
  if (!requests.permitted())
    return {refused(gateway_CAUSE_RIGHT,
                    "the identity has no right to end requests of others, which engineers have; nothing was "
                    "sent")};
  if (auto problem = obstacle()) return {*std::move(problem)};
  const bool matched =
      wait(kForAMatch, [&] { return sight().is_read(requests) && sight().is_written(replies); });
  if (!matched && stopped()) return cancelled("cancelled; nothing was sent");
  if (!matched)
    return {
        refused(gateway_CAUSE_KIND,
                "the daemon does not take it: it is older than this program, or its bus takes no requests; "
                "nothing was sent")};
  gateway_JobEnd request = {};
  request.job = job;
  Begun begun = begin(requests, request, "engineer");
  if (begun.not_begun) return {*std::move(begun.not_begun)};
  EndedOther ended{{.reason = "the daemon did not answer"}};
  (void)wait(kForAReply, [&] {
    replies.take([&](const gateway_JobEndReply& reply) {
      hand_on(reply, EndedOther{.what = std::string(text(reply.ended))},
              [&](std::uint64_t /*request*/, const EndedOther& one) { ended = one; });
    });
    return ended.replied;
  });
  if (!ended.replied && stopped())
    return cancelled("cancelled; `cansync jobs` shows whether the job has ended");
  return ended;
}

}  // namespace gateway::dds
