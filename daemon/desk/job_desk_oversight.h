#pragma once

#include <fmt/format.h>

#include <string>
#include <utility>
#include <vector>

#include "daemon/desk/job_desk.h"
#include "daemon/desk/job_desk_requests.h"

/// What everybody may see of the requests that are open, and what engineers may end of them.
namespace cansyncd {

template <RequestProtocol P>
bool JobDesk<P>::take_ends(const Context& context) {
  const auto take = [&](const gateway_JobEnd& sample, const Place& place, Right /*right*/,
                        std::int64_t written) {
    Job asked;
    asked.topic = kEnd;
    asked.key = gateway::dds::key_of(sample);
    asked.place = place;
    asked.who = who_of(gateway::dds::text(sample.client_name), asked.key, place);
    asked.change = Change{JobEndTopic::kAction, -1, fmt::format("job {}", sample.job), "ended"};
    take_end(sample, std::move(asked), written, context);
  };
  return ends_.take(places_, stopping_, take);
}

template <RequestProtocol P>
void JobDesk<P>::take_end(const gateway_JobEnd& sample, Job asked, std::int64_t written,
                          const Context& context) {
  if (admit(asked, written, context) == nullptr) return;
  if (gateway::dds::addressee(gateway::dds::daemon_of(sample), daemon_) !=
      gateway::dds::Addressee::this_daemon)
    return refuse(asked, {gateway_CAUSE_OTHER_DAEMON, std::string(kNamesNoDaemon)}, context);
  const auto found = jobs_.find(sample.job);
  if (found == jobs_.end() || found->second.topic == kOwn) {
    return refuse(asked,
                  {gateway_CAUSE_UNKNOWN_JOB,
                   fmt::format("job {}: no request is open under that number; it may have ended, and "
                               "'cansync jobs' lists those that are open",
                               sample.job)},
                  context);
  }
  const std::string what =
      fmt::format("{} of {}", open_text(found->second, context), found->second.who.label);
  audit_.ended(asked.who, *asked.change, what, {"done", true}, context.now);
  cancel(found, context);
  ends_.replies().send(JobEndTopic::done(asked.key, what), asked.place, context.now);
}

template <RequestProtocol P>
std::string JobDesk<P>::open_text(const Job& job, const Context& context) const {
  if constexpr (requires { protocol_.open_text(job.request, context); }) {
    return protocol_.open_text(job.request, context);
  }
  if (!job.change) return "a request that only reads";
  std::string text(job.change->action);
  if (job.change->slave >= 0) text += " to " + job.change->slave_text();
  for (const std::string& part : {job.change->what, job.change->new_value}) {
    if (!part.empty()) text += ' ' + part;
  }
  return text;
}

template <RequestProtocol P>
std::optional<SteadyTime> JobDesk<P>::tell_open(const Context& context) {
  if (looks_told_ != readers_.living().looks()) open_requests_.touch();
  if (!open_requests_.due(context.now)) return open_requests_.next();
  looks_told_ = readers_.living().looks();
  std::vector<JobId> ids;
  std::size_t open = 0;
  for (const auto& [id, job] : jobs_) {
    if (job.topic == kOwn) continue;
    ++open;
    if (ids.size() < OpenRequestsTopic::kRequests) ids.push_back(id);
  }
  const std::vector<LaneTurn> turns = lanes_.turns(ids);
  std::vector<OpenRequest> requests;
  requests.reserve(ids.size());
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const Job& job = jobs_.at(ids[i]);
    requests.push_back({ids[i], job.key, job.place, job.who.name, open_text(job, context), job.time, turns[i],
                        job.done, job.data.size()});
  }
  open_requests_.tell(requests, open, book_.clients(), readers_.living(), context.now);
  return std::nullopt;
}

}  // namespace cansyncd
