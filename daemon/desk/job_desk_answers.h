#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <utility>

#include "daemon/desk/job_desk.h"
#include "daemon/desk/job_desk_requests.h"
#include "text/counts.h"

/// Answers on their way out; requests are in job_desk_requests.h.
namespace cansyncd {

template <RequestProtocol P>
void JobDesk<P>::finish(const Terminal& terminal, const Context& context) {
  const auto found = jobs_.find(protocol_.id_of(terminal));
  if (found == jobs_.end()) return;
  Job& job = found->second;
  if (const auto refused = protocol_.refusal(terminal, job.request, context)) {
    refuse(job, *refused, context);
  } else {
    answer(job, terminal, context);
  }
  erase(found, context.now);
}

template <RequestProtocol P>
void JobDesk<P>::answer(Job& job, const Terminal& terminal, const Context& context) {
  record_end(job, protocol_.outcome_of(terminal), context);
  if constexpr (requires { protocol_.learn(job.request, terminal); }) {
    protocol_.learn(job.request, terminal);
  }
  with_topic(job.topic, [&]<class Row>(RequestTopic<Row>& topic) {
    // The reply borrows the data, so both go together.
    const auto reply = Row::answer(job.key, terminal, job.request, std::span(job.data), context);
    book_.let_go(job.key, job.data.size());
    topic.replies().send(reply, job.place, context.now, std::move(job.data));
    job.data = {};
  });
}

template <RequestProtocol P>
void JobDesk<P>::end(Job& job, Outcome outcome, const Context& context) {
  record_end(job, outcome, context);
  with_topic(job.topic, [&]<class Row>(RequestTopic<Row>& topic) {
    topic.replies().send(Row::ended(job.key, outcome), job.place, context.now);
  });
}

template <RequestProtocol P>
void JobDesk<P>::progress(JobId id, std::uint32_t bytes, SteadyTime now) {
  const auto found = jobs_.find(id);
  if (found == jobs_.end()) return;
  Job& job = found->second;
  job.done = bytes;
  open_requests_.touch();
  if (now < job.next_progress) return;
  job.next_progress = now + kProgressPeriod;
  with_topic(job.topic, [&](auto& topic) { topic.tell_progress(job.key, job.done, job.data.size()); });
}

template <RequestProtocol P>
std::optional<SteadyTime> JobDesk<P>::show_open_transfers(SteadyTime now) {
  if (book_.bytes() == 0) return std::nullopt;
  if (now < next_sign_) return next_sign_;
  next_sign_ = now + kSignPeriod;
  for (const auto& entry : jobs_) {
    const Job& job = entry.second;
    with_topic(job.topic, [&](auto& topic) { topic.tell_progress(job.key, job.done, job.data.size()); });
  }
  return next_sign_;
}

template <RequestProtocol P>
void JobDesk<P>::erase(typename Jobs::iterator job, SteadyTime now) {
  open_requests_.touch();
  lanes_.remove(job->first);
  const auto key = job->second.key;
  const bool own = job->second.topic == kOwn;
  const std::size_t bytes = job->second.data.size();
  jobs_.erase(job);
  if (!own && book_.close(key, bytes)) forget(key.client, now);
}

template <RequestProtocol P>
void JobDesk<P>::cancel(typename Jobs::iterator job, const Context& context) {
  if (lanes_.waits(job->first)) {
    end(job->second, P::kCancelled, context);
    return erase(job, context.now);
  }
  job->second.cancel_wanted = true;
  cancels_waiting_ = true;
}

template <RequestProtocol P>
void JobDesk<P>::replace_waiting(const Newer& newer, const Context& context) {
  if constexpr (Replaces<P>) {
    for (auto next = jobs_.begin(); next != jobs_.end();) {
      const auto job = next++;
      if (!lanes_.waits(job->first) || !protocol_.loses_to(job->second.request, newer, context)) continue;
      end(job->second, P::kReplaced, context);
      erase(job, context.now);
    }
  }
}

template <RequestProtocol P>
void JobDesk<P>::make_way_for(const Request& newer, const Context& context) {
  if constexpr (Replaces<P>) {
    if (const auto what = protocol_.newer_of(newer, context)) replace_waiting(*what, context);
  }
}

template <RequestProtocol P>
void JobDesk<P>::look_for_clients(const Context& context) {
  for (const ClientIdentity& identity : book_.clients().mark_gone(readers_.look(places_, context.now))) {
    const ClientEntry client = *book_.clients().find(identity);
    if (client.open == 0) {
      forget(identity, context.now);
    } else {
      tell_gone(identity, client, context);
    }
  }
}

template <RequestProtocol P>
void JobDesk<P>::tell_gone(const ClientIdentity& identity, const ClientEntry& client,
                           const Context& context) {
  const auto is_its = [&](const auto& job) {
    return job.second.topic != kOwn && job.second.key.client == identity;
  };
  const auto any = std::find_if(jobs_.begin(), jobs_.end(), is_its);
  const std::string name = any == jobs_.end() ? client.who : any->second.who.name;
  events_.publish({gateway_SEVERITY_WARNING, "client_gone", -1,
                   fmt::format("{} is gone; its {} cancelled", client.who,
                               text::counted(client.open, "open request is", "open requests are")),
                   std::nullopt, std::nullopt, name},
                  context.now);
  for (auto job = jobs_.begin(); job != jobs_.end();) {
    const auto here = job++;
    if (is_its(*here)) cancel(here, context);
  }
}

template <RequestProtocol P>
void JobDesk<P>::stop_and_deliver(gateway::dds::DataSignal& signal, const std::function<Context()>& context) {
  constexpr std::chrono::milliseconds kPatience{500};
  constexpr int kLook = 20;
  const SteadyTime end = std::chrono::steady_clock::now() + kPatience;
  stop(context());
  while (replies_waiting() && std::chrono::steady_clock::now() < end) {
    (void)signal.wait(kLook);
    signal.clear();
    (void)retry(context());
  }
  wait_for_readers(DDS_MSECS(kPatience.count()));
}

template <RequestProtocol P>
void JobDesk<P>::forget(const ClientIdentity& identity, SteadyTime now) {
  book_.clients().erase(identity);
  each_outbox([&](auto& topic) { topic.forget(identity, now); });
}

template <RequestProtocol P>
std::string JobDesk<P>::before(const Job& job) {
  if (!job.understood) return AuditTrail::kNotKnown;
  if constexpr (requires { protocol_.before(job.request, job.state_before); }) {
    return protocol_.before(job.request, job.state_before);
  } else {
    return AuditTrail::kNotKnown;
  }
}

template <RequestProtocol P>
void JobDesk<P>::record_end(const Job& job, Outcome outcome, const Context& context) {
  std::optional<Change> change = job.change;
  if (change && change->hashed && !job.data.empty()) {
    if (const std::string hash = hash_text(job.data.data(), job.data.size()); !hash.empty())
      change->new_value += ", " + hash;
  }
  if constexpr (GivesOwn<P>) {
    if (job.topic == kOwn) change = Change{"configuration", -1, "", protocol_.text(job.request, context)};
  }
  if (change) {
    audit_.ended(job.who, *change, before(job), {protocol_.name(outcome), protocol_.is_done(outcome)},
                 context.now);
  }
  if constexpr (requires { protocol_.ended(job.request, outcome); }) protocol_.ended(job.request, outcome);
}

template <RequestProtocol P>
void JobDesk<P>::tell_dropped(SteadyTime now) {
  each_outbox([&](auto& topic) { dropped_.add(topic.replies().take_dropped()); });
  const std::uint64_t dropped = dropped_.take(now);
  if (dropped == 0) return;
  events_.publish(
      {gateway_SEVERITY_ERROR, "replies_dropped", -1,
       fmt::format(
           "{} could not be delivered; a client does not read its replies, or not in the partition for them "
           "(the bus, a slash and its identity)",
           text::counted(dropped, "reply")),
       std::nullopt},
      now);
}

template <RequestProtocol P>
void JobDesk<P>::stop(const Context& context) {
  stopping_ = true;
  // Clients that write without a rest must not keep the daemon from stopping.
  constexpr int kLooks = 64;
  for (int look = 0; look < kLooks && take_requests(context); ++look) {
  }
  for (auto& [id, job] : jobs_) {
    end(job, P::kStopped, context);
    if (!job.data.empty()) abandoned_.push_back(std::move(job.data));
  }
  jobs_.clear();
  lanes_ = FairLanes(protocol_.lane_limits());
  book_.close_all();
}

template <RequestProtocol P>
bool JobDesk<P>::replies_waiting() const noexcept {
  return !ends_.replies().empty() ||
         std::apply([](const auto&... topic) { return (!topic.replies().empty() || ...); }, topics_.all);
}

template <RequestProtocol P>
void JobDesk<P>::wait_for_readers(dds_duration_t time) const noexcept {
  std::apply([&](const auto&... topic) { (topic.replies().wait_for_readers(time), ...); }, topics_.all);
  ends_.replies().wait_for_readers(time);
}

}  // namespace cansyncd
