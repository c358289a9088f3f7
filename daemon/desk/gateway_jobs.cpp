#include "daemon/desk/gateway_jobs.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "daemon/cansync/requests/gateway_requests.h"
#include "daemon/cansync/texts/profile_rules.h"
#include "daemon/cansync/texts/refusal_text.h"
#include "dds/malformed.h"

/// Requests on their way in; their answers are in gateway_results.cpp.
namespace cansyncd {
namespace {

namespace dds = cansync::dds;
using cansync::JobId;

/// Bytes of memory a request needs until it is answered.
std::size_t bytes_of(const cansync_TransferRequest& sample) noexcept {
  return sample.direction == cansync_DIRECTION_DOWNLOAD ? sample.data._length : sample.length;
}
template <class Sample>
std::size_t bytes_of(const Sample& /*sample*/) noexcept {
  return 0;
}

/// The queue of the master a request waits in.
Lane lane_of(const Request& request) noexcept {
  if (const auto* job = std::get_if<cansync::ParameterRequest>(&request)) {
    return {LaneKind::parameter, job->slave.value()};
  }
  if (const auto* job = std::get_if<cansync::TransferRequest>(&request)) {
    return {LaneKind::transfer, job->slave.value()};
  }
  if (const auto* job = std::get_if<cansync::ControlWordRequest>(&request)) {
    return {LaneKind::control_word, job->slave.value()};
  }
  if (const auto* job = std::get_if<cansync::BroadcastRequest>(&request)) {
    return {LaneKind::broadcast, job->priority};
  }
  return {};
}

Requester who_of(std::string_view name, const dds::RequestKey& key, const Place& place) {
  Requester who;
  who.name = name;
  who.request = key.request;
  const auto& client = key.client;
  who.label =
      fmt::format("'{}' ({:02x}{:02x}{:02x}{:02x})", name, client[0], client[1], client[2], client[3]);
  if (place != Place{}) {
    for (const unsigned byte : place) who.participant += fmt::format("{:02x}", byte);
  }
  return who;
}

template <class Sample>
dds::KeyGuard::Content content_of(const void* sample) {
  const auto& request = *static_cast<const Sample*>(sample);
  dds::KeyGuard::Content content{dds::key_of(request)};
  if constexpr (requires { request.data; }) content.bytes = request.data._length;
  return content;
}

}  // namespace

JobDesk::JobDesk(const dds::Participant& participant, dds::DataSignal& signal, EventPublisher& events,
                 const Config& config, AuditTrail& audit)
    : guards_{dds::KeyGuard(content_of<cansync_ParameterRequest>, signal),
              dds::KeyGuard(content_of<cansync_TransferRequest>, signal),
              dds::KeyGuard(content_of<cansync_Command>, signal),
              dds::KeyGuard(content_of<gateway_JobCancel>, signal),
              dds::KeyGuard(content_of<cansync_Command>, signal)},
      parameters_(participant, &signal, &guards_[kParameters]),
      transfers_(participant, &signal, &guards_[kTransfers]),
      commands_(participant, &signal, &guards_[kCommands]),
      cancels_(participant, &signal, &guards_[kCancels]),
      parameter_replies_(participant, signal),
      transfer_replies_(participant, signal),
      command_replies_(participant, signal),
      progress_(participant),
      events_(events),
      audit_(audit),
      limits_(dds::limits_of(config.master)),
      rejections_(events),
      lanes_(lane_limits(config.master.command_channel)) {
  if (!config.dds.security.empty())
    engineer_commands_.emplace(participant, dds::kEngineerCommandTopic, &signal, &guards_[kEngineer]);
}

bool JobDesk::take_requests(const JobContext& context) {
  // Permissions of DDS Security are by topic; without it everybody may do everything.
  // Control words first, and few of the others before they are looked at again.
  bool more = accept(commands_, kCommands, engineer_commands_ ? Right::operate : Right::engineer, context);
  if (engineer_commands_) more = accept(*engineer_commands_, kEngineer, Right::engineer, context) || more;
  more = take_cancels(context) || more;
  more = take_parameters(context) || more;
  more = accept(transfers_, kTransfers, Right::engineer, context) || more;
  more = refuse_turned_away(context) || more;
  // After the samples: what a client left behind is cancelled before it is handed on.
  look_for_clients(context);
  return more;
}

template <class Sample>
bool JobDesk::accept(dds::Reader<Sample>& reader, ReaderIndex index, Right right, const JobContext& context) {
  const auto count = reader.take_batch([&](const Sample& sample, const dds_sample_info_t& info) {
    if (!info.valid_data) return;
    guards_[index].taken(info.instance_handle, content_of<Sample>(&sample).bytes);
    accept(sample, places_.find(reader.handle(), info.publication_handle), right, info.source_timestamp,
           context);
  });
  return count == dds::ReaderBase::kBatch;
}

bool JobDesk::take_parameters(const JobContext& context) {
  if (parameters_taken_.empty()) {
    (void)parameters_.take_batch([&](const cansync_ParameterRequest& sample, const dds_sample_info_t& info) {
      if (!info.valid_data) return;
      guards_[kParameters].taken(info.instance_handle, 0);
      parameters_taken_.push_back(
          {sample, places_.find(parameters_.handle(), info.publication_handle), info.source_timestamp});
    });
  }
  const auto most = stopping_ ? parameters_taken_.size() : kParametersAtOnce;
  for (std::size_t i = 0; i < most && !parameters_taken_.empty(); ++i) {
    const TakenParameter& next = parameters_taken_.front();
    accept(next.sample, next.place, Right::engineer, next.written, context);
    parameters_taken_.pop_front();
    if (parameters_taken_.empty()) return true;  // there may be more in the reader
  }
  return !parameters_taken_.empty();
}

bool JobDesk::refuse_turned_away(const JobContext& context) {
  const std::array<dds_entity_t, kReaders> readers = reader_handles();
  constexpr std::array<Kind, kReaders> kKinds = {Kind::parameter, Kind::transfer, Kind::command,
                                                 Kind::internal, Kind::command};
  bool more = false;
  for (std::size_t i = 0; i < kReaders; ++i) {
    const auto refused = guards_[i].take_turned_away(kRefusedAtOnce);
    more = more || refused.size() == kRefusedAtOnce;
    for (const dds::KeyGuard::TurnedAway& sample : refused) {
      Job job;
      job.kind = kKinds[i];
      job.key = sample.key;
      job.place = places_.find(readers[i], sample.writer);
      const ClientEntry* client = clients_.find(job.key.client);
      job.who = who_of("", job.key, job.place);
      if (client != nullptr) job.who.label = client->who;
      const std::string reason = too_many_requests(dds::KeyGuard::kSamplesPerKey, kPerClient);
      if (job.kind == Kind::internal || (client != nullptr && client->place != job.place)) {
        // A cancel has no reply of its own, and who uses another's identity gets none.
        rejections_.add(Rejection::full, job.who.name,
                        fmt::format("request {} of {}: {}", job.key.request, job.who.label, reason),
                        context.now);
      } else {
        refuse(job, Rejection::full, reason, context);
      }
    }
  }
  return more;
}

template <class Sample>
void JobDesk::accept(const Sample& sample, const Place& place, Right right, std::int64_t written,
                     const JobContext& context) {
  Job job;
  job.key = dds::key_of(sample);
  job.place = place;
  job.who = who_of(dds::text(sample.client_name), job.key, place);
  job.change = change_of(sample);
  job.state_before = context.line.state;
  if constexpr (std::is_same_v<Sample, cansync_ParameterRequest>) {
    job.kind = Kind::parameter;
    if (job.change) job.change->what = parameter_text(context.config, sample);
  }
  if constexpr (std::is_same_v<Sample, cansync_TransferRequest>) job.kind = Kind::transfer;
  if constexpr (std::is_same_v<Sample, cansync_Command>) job.kind = Kind::command;

  ClientEntry* client = admit(job, written, context);
  if (client == nullptr) return;
  if (const auto problem = dds::check(sample, limits_)) {
    return refuse(job, Rejection::value, *problem, context);
  }
  if (const auto problem = no_room(*client, bytes_of(sample))) {
    return refuse(job, Rejection::full, *problem, context);
  }
  const JobId id = next_id_++;
  if (!fill(sample, id, job)) {
    return refuse(job, Rejection::value, "kind: not known to this daemon", context);
  }
  job.understood = true;
  auto forbidden = right_refusal(job.request, right);
  if (!forbidden) forbidden = read_only_refusal(job.request, context.config);
  if (forbidden) return refuse(job, Rejection::state, *forbidden, context);
  if (const auto problem = profile_refusal(job.request, context.config)) {
    return refuse(job, Rejection::value, *problem, context);
  }
  if (take_early_cancel(*client, job.key.request, context.now)) {
    return end(job, cansync::Outcome::cancelled, context);
  }
  replace_waiting(job.request, context);
  ++client->open;
  client->transfer_bytes += job.data.size();
  transfer_bytes_ += job.data.size();
  open_.emplace(Key{job.key.client, job.key.request}, id);
  lanes_.add(id, job.key.client, lane_of(job.request));
  jobs_.emplace(id, std::move(job));
}

ClientEntry* JobDesk::admit(Job& job, std::int64_t written, const JobContext& context) {
  const auto [client, admission] = clients_.enter(job.key.client, job.place, job.who.label);
  const auto refused = [&](Rejection kind, const std::string& reason) {
    refuse(job, kind, reason, context);
    return nullptr;
  };
  if (admission == ClientTable::Admission::foreign) {
    rejections_.add(
        Rejection::identity, job.who.name,
        fmt::format("request {} of {} has the identity of another program that is running; it gets no reply: "
                    "every program chooses an identity of its own, at random, when it starts",
                    job.key.request, job.who.label),
        context.now);
    audit_.refused(job.who, job.change, nullptr, job.state_before, "the identity of another program",
                   context.now);
    return nullptr;
  }
  if (stopping_) {
    end(job, cansync::Outcome::master_stopped, context);
    return nullptr;
  }
  if (admission == ClientTable::Admission::leaving) {
    return refused(
        Rejection::identity,
        "client: the program that had this identity is gone, and its requests are not all cancelled yet; "
        "choose an identity at random at every start");
  }
  if (admission == ClientTable::Admission::full) {
    refuse(job, Rejection::full, too_many_clients(clients_.size(), ClientTable::kClients), context);
    forget(job.key.client, context.now);
    return nullptr;
  }
  const std::uint64_t number = job.key.request;
  if (!client->numbers.use(number)) {
    if (open_.contains({job.key.client, number})) {
      return refused(Rejection::number,
                     fmt::format("request {}: this number is open already and is answered by itself; every "
                                 "request needs a number of its own, rising by one",
                                 number));
    }
    return refused(
        Rejection::number,
        fmt::format("request {}: this number was used already, or is too far behind the highest, {}; every "
                    "request needs a number of its own, rising by one",
                    number, client->numbers.highest()));
  }
  if (const auto problem = stale(written, wall_clock_now(), context.config.dds.request_max_age)) {
    return refused(Rejection::stale, *problem);
  }
  return client;
}

bool JobDesk::fill(const cansync_ParameterRequest& sample, JobId id, Job& job) {
  job.request = dds::to_core(sample, id);
  return true;
}

bool JobDesk::fill(const cansync_TransferRequest& sample, JobId id, Job& job) {
  job.data.resize(bytes_of(sample));
  if (sample.direction == cansync_DIRECTION_DOWNLOAD) {
    std::copy_n(sample.data._buffer, sample.data._length, job.data.begin());
  }
  // The vector's memory stays where it is when the job is moved.
  job.request = dds::to_core(sample, id, job.data);
  return true;
}

bool JobDesk::fill(const cansync_Command& sample, JobId id, Job& job) {
  auto request = to_request(sample, id);
  if (!request) return false;
  job.request = *request;
  return true;
}

std::optional<std::string> JobDesk::no_room(const ClientEntry& client, std::size_t bytes) const {
  if (client.open >= kPerClient) return too_many_requests(client.open, kPerClient);
  if (client.transfer_bytes + bytes > kClientTransferMemory)
    return too_many_bytes_of_client(bytes, client.transfer_bytes, kClientTransferMemory);
  if (transfer_bytes_ + bytes > kTransferMemory)
    return too_many_bytes(bytes, transfer_bytes_, kTransferMemory);
  return std::nullopt;
}

void JobDesk::refuse(const Job& job, Rejection kind, const std::string& reason, const JobContext& context) {
  if (job.kind == Kind::internal) {
    const EventText event{gateway_SEVERITY_ERROR, "configuration_refused", -1,
                          fmt::format("a changed setting was not taken: {}", reason), std::nullopt};
    // A reload may have many, and each is wanted in the journal.
    if (!events_.publish(event, context.now)) events_.record(event);
    return;
  }
  // Recorded and counted first: whoever has the reply finds both.
  if (job.change) {
    audit_.refused(job.who, job.change, job.understood ? &job.request : nullptr, job.state_before, reason,
                   context.now);
  }
  rejections_.add(kind, job.who.name,
                  fmt::format("request {} of {} refused: {}", job.key.request, job.who.label, reason),
                  context.now);
  switch (job.kind) {
    case Kind::parameter:
      parameter_replies_.send(dds::parameter_refused(job.key, reason), job.place, context.now);
      break;
    case Kind::transfer:
      transfer_replies_.send(dds::transfer_refused(job.key, reason), job.place, context.now);
      break;
    case Kind::command:
      command_replies_.send(dds::command_refused(job.key, reason), job.place, context.now);
      break;
    case Kind::internal:
      break;
  }
}

bool JobDesk::take_cancels(const JobContext& context) {
  const auto count = cancels_.take_batch([&](const gateway_JobCancel& sample, const dds_sample_info_t& info) {
    if (!info.valid_data) return;
    guards_[kCancels].taken(info.instance_handle, 0);
    take_cancel(dds::key_of(sample), places_.find(cancels_.handle(), info.publication_handle), context);
  });
  return count == dds::ReaderBase::kBatch;
}

void JobDesk::take_cancel(const dds::RequestKey& key, const Place& place, const JobContext& context) {
  const std::string who = who_of("", key, place).label;
  const auto [client, admission] = clients_.enter(key.client, place, who);
  if (admission == ClientTable::Admission::foreign) {
    return rejections_.add(
        Rejection::identity, who,
        fmt::format("cancel of request {} of {} comes from another program than the request", key.request,
                    who),
        context.now);
  }
  if (client == nullptr) return;
  if (const auto found = open_.find({key.client, key.request}); found != open_.end()) {
    return cancel(jobs_.find(found->second), context);
  }
  // Either the job has ended, and nothing is left to do, or its request is still on its way.
  auto& early = client->early_cancels;
  if (early.size() == kEarlyCancels) early.pop_front();
  early.emplace_back(key.request, context.now);
}

bool JobDesk::take_early_cancel(ClientEntry& client, std::uint64_t request, SteadyTime now) {
  auto& early = client.early_cancels;
  while (!early.empty() && now - early.front().second > kEarlyCancel) early.pop_front();
  const auto found =
      std::find_if(early.begin(), early.end(), [&](const auto& item) { return item.first == request; });
  if (found == early.end()) return false;
  early.erase(found);
  return true;
}

void JobDesk::give(Request request) {
  own_.push_back(request);
}

std::optional<SteadyTime> JobDesk::retry(const JobContext& context) {
  auto& requests = context.exchange.requests;
  if (cancels_waiting_) {
    cancels_waiting_ = false;
    for (auto& [id, job] : jobs_) {
      if (!job.cancel_wanted) continue;
      job.cancel_wanted = !requests.try_push(Cancel{id});
      cancels_waiting_ = cancels_waiting_ || job.cancel_wanted;
    }
  }
  while (!own_.empty()) {
    const JobId id = next_id_;
    std::visit(
        [id](auto& request) {
          if constexpr (requires { request.id; }) request.id = id;
        },
        own_.front());
    if (!requests.try_push(own_.front())) break;
    ++next_id_;
    Job& job = jobs_[id];
    job.request = own_.front();
    job.who.name = job.who.label = "the configuration file";
    own_.pop_front();
  }
  lanes_blocked_ = !lanes_.hand_over([&](JobId id) { return requests.try_push(jobs_.at(id).request); });
  parameter_replies_.retry(context.now);
  transfer_replies_.retry(context.now);
  command_replies_.retry(context.now);
  tell_dropped(context.now);

  std::optional<SteadyTime> next = audit_.tick(context.now);
  const auto earlier = [&next](std::optional<SteadyTime> time) {
    if (time && (!next || *time < *next)) next = time;
  };
  earlier(show_open_transfers(context.now));
  earlier(dropped_.next());
  earlier(parameter_replies_.next(context.now));
  earlier(transfer_replies_.next(context.now));
  earlier(command_replies_.next(context.now));
  count_dropped(context.now);
  earlier(rejections_.tick(context.now));
  // The realtime thread wakes nobody when it has made room.
  constexpr std::chrono::milliseconds kLookForRoom{10};
  if (cancels_waiting_ || lanes_blocked_ || !own_.empty()) earlier(context.now + kLookForRoom);
  return next;
}

void JobDesk::count_dropped(SteadyTime now) {
  std::uint64_t keys = 0;
  for (dds::KeyGuard& guard : guards_) keys += guard.take_dropped();
  if (keys != 0) {
    rejections_.add(
        Rejection::identity, "",
        fmt::format("{} samples were dropped unread: one program may use {} client identities at a time, all "
                    "together {}",
                    keys, dds::KeyGuard::kKeysPerWriter, dds::KeyGuard::kKeys),
        now, keys);
  }
  std::uint64_t forgotten = 0;
  for (dds::KeyGuard& guard : guards_) forgotten += guard.take_forgotten();
  if (forgotten != 0) {
    rejections_.add(
        Rejection::full, "",
        fmt::format("{} requests were dropped without a reply: their program writes on while {} of its "
                    "requests wait and {} are being refused",
                    forgotten, kPerClient, dds::KeyGuard::kTurnedAwayPerKey),
        now, forgotten);
  }
  const dds::Malformed malformed = dds::take_malformed();
  for (const std::string& line : malformed.further)
    events_.publish({gateway_SEVERITY_WARNING, "dds_message", -1, "DDS says: " + line, std::nullopt}, now);
  if (malformed.count != 0) {
    rejections_.add(
        Rejection::malformed, "",
        fmt::format(
            "{} samples or packets were dropped because DDS could not read them (an unknown enumerator, a "
            "sequence over its bound, another data model?); the newest: {}",
            malformed.count, malformed.newest),
        now, malformed.count);
  }
}

void JobDesk::tell_dropped(SteadyTime now) {
  dropped_.add(parameter_replies_.take_dropped() + transfer_replies_.take_dropped() +
               command_replies_.take_dropped());
  const std::uint64_t dropped = dropped_.take(now);
  if (dropped == 0) return;
  events_.publish(
      {gateway_SEVERITY_ERROR, "replies_dropped", -1,
       fmt::format("{} replies could not be delivered; a client does not read its replies", dropped),
       std::nullopt},
      now);
}

}  // namespace cansyncd
