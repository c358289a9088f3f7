#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <type_traits>
#include <utility>

#include "daemon/desk/job_desk.h"
#include "daemon/desk/limits_text.h"
#include "dds/bounded_text.h"

/// Requests on their way in; their answers are in job_desk_answers.h, what others see and end of them in
/// job_desk_oversight.h.
namespace cansyncd {

template <RequestProtocol P>
JobDesk<P>::JobDesk(const gateway::dds::Participant& participant, gateway::dds::DataSignal& signal,
                    EventPublisher& events, AuditTrail& audit, P protocol,
                    const gateway::dds::DaemonIdentity& daemon, bool secured)
    : protocol_(std::move(protocol)),
      daemon_(daemon),
      topics_(TopicSetup{participant, signal, readers_, daemon, secured}),
      cancels_({participant, signal, readers_, daemon, secured}, gateway::dds::topic_info<gateway_JobCancel>,
               Right::operate),
      ends_({participant, signal, readers_, daemon, secured}),
      open_requests_(participant, daemon),
      events_(events),
      audit_(audit),
      rejections_(events),
      book_(daemon),
      lanes_(protocol_.lane_limits()) {}

template <RequestProtocol P>
template <class Use>
void JobDesk<P>::each_topic(Use&& use) {
  [&]<std::size_t... kIndex>(std::index_sequence<kIndex...>) {
    (use(std::get<kIndex>(topics_.all), kIndex), ...);
  }
  (std::make_index_sequence<kTopics>{});
}

template <RequestProtocol P>
template <class Use>
void JobDesk<P>::each_outbox(Use&& use) {
  each_topic([&](auto& topic, std::size_t) { use(topic); });
  use(ends_);
}

template <RequestProtocol P>
template <class Use>
void JobDesk<P>::with_topic(std::size_t index, Use&& use) {
  each_topic([&](auto& topic, std::size_t its) {
    if (its == index) use(topic);
  });
}

template <RequestProtocol P>
bool JobDesk<P>::take_requests(const Context& context) {
  bool more = false;
  const auto take = [&](bool urgent) {
    each_topic([&]<class Row>(RequestTopic<Row>& topic, std::size_t index) {
      constexpr bool kUrgent = requires {
        Row::kUrgent;
      };
      if (kUrgent == urgent) more = accept_from(topic, index, context) || more;
    });
  };
  // The urgent first, and few of the others before they are looked at again.
  take(true);
  more = take_cancels(context) || more;
  more = take_ends(context) || more;
  take(false);
  more = refuse_turned_away(context) || more;
  // After the samples: what a client left behind is cancelled before it is handed on.
  look_for_clients(context);
  return more;
}

template <RequestProtocol P>
template <class Topic>
bool JobDesk<P>::accept_from(Topic& topic, std::size_t index, const Context& context) {
  using Sample = typename Topic::Sample;
  const auto take = [&](const Sample& sample, const Place& place, Right right, std::int64_t written) {
    Job job;
    job.topic = index;
    job.key = gateway::dds::key_of(sample);
    job.place = place;
    job.who = who_of(gateway::dds::text(sample.client_name), job.key, place);
    accept<typename Topic::RowType>(sample, std::move(job), right, written, context);
  };
  return topic.take(places_, stopping_, take);
}

template <RequestProtocol P>
bool JobDesk<P>::refuse_turned_away(const Context& context) {
  const gateway::dds::Denial denial =
      too_many_requests(gateway::dds::KeyGuard::kSamplesPerKey, JobBook::kPerClient);
  const auto refuse_of = [&](std::size_t topic, const gateway::dds::RequestKey& key, const Place& place) {
    Job job;
    job.topic = topic;
    job.key = key;
    job.place = place;
    const ClientEntry* client = book_.clients().find(key.client);
    job.who = who_of("", key, place);
    if (client != nullptr) job.who.label = client->who;
    if (topic == kOwn || (client != nullptr && client->place != place)) {
      // A cancel has no reply of its own, and who uses another's identity gets none.
      rejections_.add(Rejection::full, job.who.name,
                      fmt::format("request {} of {}: {}", key.request, job.who.label, text_of(denial)),
                      context.now);
    } else {
      refuse(job, denial, context);
    }
  };
  bool more = cancels_.take_turned_away(
      places_, [&](const auto& key, const Place& place) { refuse_of(kOwn, key, place); });
  each_topic([&](auto& topic, std::size_t index) {
    const auto refuse_one = [&](const auto& key, const Place& place) { refuse_of(index, key, place); };
    more = topic.take_turned_away(places_, refuse_one) || more;
  });
  more = ends_.take_turned_away(places_, [&](const auto& key, const Place& place) {
    refuse_of(kEnd, key, place);
  }) || more;
  return more;
}

template <RequestProtocol P>
template <class Row>
void JobDesk<P>::accept(const typename Row::Sample& sample, Job job, Right right, std::int64_t written,
                        const Context& context) {
  job.change = protocol_.change_of(sample, context);
  if constexpr (KeepsState<P>) job.state_before = protocol_.state(context);
  ClientEntry* client = admit(job, written, context);
  if (client == nullptr) return;
  // What names another start was not let in.
  if (gateway::dds::addressee(gateway::dds::daemon_of(sample), daemon_) !=
      gateway::dds::Addressee::this_daemon)
    return refuse(job, {gateway_CAUSE_OTHER_DAEMON, std::string(kNamesNoDaemon)}, context);
  if (const auto problem = protocol_.check(sample)) {
    return refuse(job, *problem, context);
  }
  std::size_t bytes = 0;
  if constexpr (requires { Row::bytes_of(sample); }) bytes = Row::bytes_of(sample);
  if (const auto problem = book_.no_room(*client, bytes)) {
    return refuse(job, *problem, context);
  }
  const JobId id = book_.next_id();
  auto request = protocol_.request_of(sample, id, job.data);
  if (!request) return refuse(job, {gateway_CAUSE_KIND, "kind: not known to this daemon"}, context);
  job.request = std::move(*request);
  job.understood = true;
  if (const auto problem = objection(job.request, right, context)) {
    return refuse(job, *problem, context);
  }
  if (JobBook::take_early_cancel(*client, job.key.request, context.now)) {
    return end(job, P::kCancelled, context);
  }
  if (client->name.empty()) client->name = job.who.name;
  job.time = wall_clock_now();
  open_requests_.touch();
  make_way_for(job.request, context);
  book_.open(job.key, id, job.data.size());
  unsigned weight = 1;
  if constexpr (requires { P::weight_of(job.request); }) weight = P::weight_of(job.request);
  lanes_.add(id, job.key.client, protocol_.lane_of(job.request), weight);
  jobs_.emplace(id, std::move(job));
}

template <RequestProtocol P>
gateway::dds::Problem JobDesk<P>::objection(const Request& request, Right right, const Context& context) {
  const Effect effect = protocol_.effect_of(request);
  if (effect.right > right) return gateway::dds::Denial{gateway_CAUSE_RIGHT, protocol_.wrong_topic()};
  if (auto forbidden = read_only_refusal(effect, context.rules.read_only)) return forbidden;
  if constexpr (requires { protocol_.objection(request, context); }) {
    return protocol_.objection(request, context);
  }
  return std::nullopt;
}

template <RequestProtocol P>
ClientEntry* JobDesk<P>::admit(Job& job, std::int64_t written, const Context& context) {
  const auto entered = book_.clients().enter(job.key.client, job.place, job.who.label);
  if (entered.second == ClientTable::Admission::foreign) {
    rejections_.add(
        Rejection::identity, job.who.name,
        fmt::format("request {} of {} has the identity of another program that is running; it gets no reply: "
                    "every program chooses an identity of its own, at random, when it starts",
                    job.key.request, job.who.label),
        context.now);
    if (job.change) {
      audit_.refused(job.who, *job.change, AuditTrail::kNotKnown,
                     {gateway_CAUSE_IDENTITY,
                      "client: the identity of another program; choose an identity at random at every start"},
                     context.now);
    }
    return nullptr;
  }
  if (stopping_) {
    refuse(job, {gateway_CAUSE_STOPPING, "the daemon is being stopped; ask again when it runs"}, context);
    return nullptr;
  }
  const JobBook::Admission admission =
      book_.admit(job.key, entered, written, wall_clock_now(), context.rules.maximum_age);
  if (admission.client == nullptr) refuse(job, admission.denial, context);
  if (admission.forget) forget(job.key.client, context.now);
  return admission.client;
}

template <RequestProtocol P>
void JobDesk<P>::refuse(const Job& job, const gateway::dds::Denial& denial, const Context& context) {
  if (job.topic == kOwn) {
    const EventText event{gateway_SEVERITY_ERROR, "configuration_refused", -1,
                          fmt::format("a changed setting was not taken: {}", text_of(denial)), std::nullopt};
    // A reload may have many, and each is wanted in the journal.
    if (!events_.publish(event, context.now)) events_.record(event);
    return;
  }
  // Recorded and counted first: whoever has the reply finds both.
  if (job.change) {
    audit_.refused(job.who, *job.change, before(job), denial, context.now);
  }
  rejections_.add(
      rejection_of(denial.cause), job.who.name,
      fmt::format("request {} of {} refused: {}", job.key.request, job.who.label, text_of(denial)),
      context.now);
  const auto answer = [&]<class Row>(RequestTopic<Row>& topic) {
    topic.replies().send(Row::refused(job.key, denial), job.place, context.now);
  };
  if (job.topic == kEnd) return answer(ends_);
  with_topic(job.topic, answer);
}

template <RequestProtocol P>
bool JobDesk<P>::take_cancels(const Context& context) {
  return cancels_.take(places_, [&](const gateway_JobCancel& sample, const Place& place, std::int64_t) {
    take_cancel(sample, place, context);
  });
}

template <RequestProtocol P>
void JobDesk<P>::take_cancel(const gateway_JobCancel& sample, const Place& place, const Context& context) {
  const gateway::dds::RequestKey key = gateway::dds::key_of(sample);
  const std::string who = who_of("", key, place).label;
  if (gateway::dds::addressee(gateway::dds::daemon_of(sample), daemon_) !=
      gateway::dds::Addressee::this_daemon) {
    return rejections_.add(Rejection::other_daemon, who,
                           fmt::format("cancel of request {} of {}: {}", key.request, who, kNamesNoDaemon),
                           context.now);
  }
  const auto [client, admission] = book_.clients().enter(key.client, place, who);
  if (admission == ClientTable::Admission::foreign) {
    return rejections_.add(
        Rejection::identity, who,
        fmt::format("cancel of request {} of {} comes from another program than the request", key.request,
                    who),
        context.now);
  }
  if (client == nullptr) return;
  if (const auto found = book_.find(key)) return cancel(jobs_.find(*found), context);
  // Either the job has ended, and nothing is left to do, or its request is still on its way.
  JobBook::remember_cancel(*client, key.request, context.now);
}

template <RequestProtocol P>
void JobDesk<P>::give(Request request) requires GivesOwn<P> {
  own_.push_back(std::move(request));
}

template <RequestProtocol P>
void JobDesk<P>::hand_on_own(const Context& context) {
  if constexpr (GivesOwn<P>) {
    while (!own_.empty()) {
      const JobId id = book_.next_id();
      protocol_.set_id(own_.front(), id);
      if (!protocol_.hand_on(own_.front(), context)) return;
      Job& job = jobs_[id];
      job.request = std::move(own_.front());
      job.understood = true;
      job.who.name = job.who.label = "the configuration file";
      own_.pop_front();
    }
  }
}

template <RequestProtocol P>
std::optional<SteadyTime> JobDesk<P>::retry(const Context& context) {
  if (cancels_waiting_) {
    cancels_waiting_ = false;
    for (auto& [id, job] : jobs_) {
      if (!job.cancel_wanted) continue;
      job.cancel_wanted = !protocol_.hand_on_cancel(id, context);
      cancels_waiting_ = cancels_waiting_ || job.cancel_wanted;
    }
  }
  hand_on_own(context);
  lanes_blocked_ = !lanes_.hand_over([&](JobId id) {
    open_requests_.touch();
    return protocol_.hand_on(jobs_.at(id).request, context);
  });
  each_outbox([&](auto& topic) { topic.replies().retry(context.now); });
  tell_dropped(context.now);

  std::optional<SteadyTime> next = audit_.tick(context.now);
  const auto earlier = [&next](std::optional<SteadyTime> time) {
    if (time && (!next || *time < *next)) next = time;
  };
  earlier(show_open_transfers(context.now));
  earlier(dropped_.next());
  each_outbox([&](auto& topic) { earlier(topic.replies().next(context.now)); });
  earlier(tell_open(context));
  readers_.count_dropped(rejections_, events_, context.now);
  earlier(rejections_.tick(context.now));
  // The realtime thread wakes nobody when it has made room.
  constexpr std::chrono::milliseconds kLookForRoom{10};
  if (cancels_waiting_ || lanes_blocked_ || !own_.empty()) earlier(context.now + kLookForRoom);
  return next;
}

}  // namespace cansyncd
