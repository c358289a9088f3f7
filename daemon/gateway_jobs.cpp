#include "daemon/gateway_jobs.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "daemon/gateway_requests.h"
#include "daemon/gateway_take.h"
#include "daemon/log.h"

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

std::string who_of(std::string_view name, const std::array<std::uint8_t, 16>& client) {
  return fmt::format("'{}' ({:02x}{:02x}{:02x}{:02x})", name, client[0], client[1], client[2], client[3]);
}

}  // namespace

JobDesk::JobDesk(const dds::Participant& participant, dds::DataSignal& signal, EventPublisher& events,
                 const Config& config)
    : parameters_(participant, &signal),
      transfers_(participant, &signal),
      commands_(participant, &signal),
      cancels_(participant, &signal),
      parameter_replies_(participant, signal),
      transfer_replies_(participant, signal),
      command_replies_(participant, signal),
      progress_(participant),
      events_(events),
      limits_(dds::limits_of(config.master)) {}

void JobDesk::take_requests(const JobContext& context) {
  accept(commands_, context);
  accept(parameters_, context);
  accept(transfers_, context);
  take_cancels(context);
}

template <class Sample>
void JobDesk::accept(dds::Reader<Sample>& reader, const JobContext& context) {
  take_with_info(reader, [&](const Sample& sample, const dds_sample_info_t& info) {
    if (info.valid_data) accept(sample, places_.find(reader.handle(), info.publication_handle), context);
  });
}

template <class Sample>
void JobDesk::accept(const Sample& sample, const Place& place, const JobContext& context) {
  Job job;
  job.key = dds::key_of(sample);
  job.place = place;
  job.who = who_of(dds::text(sample.client_name), job.key.client);
  if constexpr (std::is_same_v<Sample, cansync_ParameterRequest>) job.kind = Kind::parameter;
  if constexpr (std::is_same_v<Sample, cansync_TransferRequest>) job.kind = Kind::transfer;
  if constexpr (std::is_same_v<Sample, cansync_Command>) job.kind = Kind::command;

  if (stopping_) return end(job, cansync::Outcome::master_stopped, context);
  if (const auto problem = dds::check(sample, limits_)) return refuse(job, *problem, context);
  if (const auto problem = no_room(job, bytes_of(sample), context)) return refuse(job, *problem, context);
  const JobId id = next_id_++;
  if (!fill(sample, id, job)) return refuse(job, "kind: not known to this daemon", context);
  const Key key{job.key.client, job.key.request};
  if (take_early_cancel(key, context.now)) return end(job, cansync::Outcome::cancelled, context);
  if (!context.exchange.requests.try_push(job.request)) {
    return refuse(
        job,
        fmt::format("request queue full: {} requests wait for the realtime thread, at most {} are allowed; "
                    "try again later",
                    context.exchange.requests.size(), context.exchange.requests.capacity()),
        context);
  }
  ++per_client_[job.key.client];
  open_.emplace(key, id);
  transfer_bytes_ += job.data.size();
  jobs_.emplace(id, std::move(job));
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

std::optional<std::string> JobDesk::no_room(const Job& job, std::size_t bytes,
                                            const JobContext& context) const {
  if (open_.contains({job.key.client, job.key.request})) {
    return fmt::format(
        "request {}: this number is open already and is answered by itself; every request needs a "
        "number of its own, rising by one",
        job.key.request);
  }
  const auto client = per_client_.find(job.key.client);
  if (client != per_client_.end() && client->second >= kPerClient) {
    return fmt::format(
        "queue full: this client has {} requests open, at most {} are allowed; wait for a reply first",
        client->second, kPerClient);
  }
  // Room for every answer the realtime thread can owe, so that it never has to wait for this thread.
  const std::size_t limit = context.exchange.requests.capacity() + context.exchange.terminals.capacity();
  if (jobs_.size() >= limit) {
    return fmt::format(
        "queue full: {} requests of all clients are open, at most {} are allowed; try again later",
        jobs_.size(), limit);
  }
  if (transfer_bytes_ + bytes > kTransferMemory) {
    return fmt::format(
        "length {}: open transfers have {} bytes, at most {} are allowed together; try again later", bytes,
        transfer_bytes_, kTransferMemory);
  }
  return std::nullopt;
}

void JobDesk::refuse(const Job& job, const std::string& reason, const JobContext& context) {
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
      events_.publish({cansync_SEVERITY_ERROR, "configuration_refused", -1,
                       fmt::format("a changed setting was not taken: {}", reason), std::nullopt},
                      context.now);
      break;
  }
  log(LogPriority::notice, "request {} of {} refused: {}", job.key.request, job.who, reason);
}

void JobDesk::take_cancels(const JobContext& context) {
  cancels_.take([&](const cansync_JobCancel& sample) {
    const auto key = dds::key_of(sample);
    const Key open{key.client, key.request};
    if (const auto found = open_.find(open); found != open_.end()) {
      jobs_.at(found->second).cancel_wanted = true;
      cancels_waiting_ = true;
      return;
    }
    // Either the job has ended, and nothing is left to do, or its request is still on its way.
    constexpr std::size_t kRemembered = 256;
    if (early_cancels_.size() == kRemembered) early_cancels_.pop_front();
    early_cancels_.emplace_back(open, context.now);
  });
}

bool JobDesk::take_early_cancel(const Key& key, SteadyTime now) {
  while (!early_cancels_.empty() && now - early_cancels_.front().second > kEarlyCancel)
    early_cancels_.pop_front();
  const auto found = std::find_if(early_cancels_.begin(), early_cancels_.end(),
                                  [&](const auto& item) { return item.first == key; });
  if (found == early_cancels_.end()) return false;
  early_cancels_.erase(found);
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
    job.who = "the configuration file";
    own_.pop_front();
  }
  parameter_replies_.retry(context.now);
  transfer_replies_.retry(context.now);
  command_replies_.retry(context.now);
  tell_dropped(context.now);

  std::optional<SteadyTime> next;
  const auto earlier = [&next](std::optional<SteadyTime> time) {
    if (time && (!next || *time < *next)) next = time;
  };
  earlier(parameter_replies_.next(context.now));
  earlier(transfer_replies_.next(context.now));
  earlier(command_replies_.next(context.now));
  // The realtime thread wakes nobody when it has made room.
  constexpr std::chrono::milliseconds kLookForRoom{10};
  if (cancels_waiting_ || !own_.empty()) earlier(context.now + kLookForRoom);
  return next;
}

void JobDesk::tell_dropped(SteadyTime now) {
  const std::uint64_t dropped =
      parameter_replies_.take_dropped() + transfer_replies_.take_dropped() + command_replies_.take_dropped();
  if (dropped == 0) return;
  events_.publish(
      {cansync_SEVERITY_ERROR, "replies_dropped", -1,
       fmt::format("{} replies could not be delivered; a client does not read its replies", dropped),
       std::nullopt},
      now);
}

}  // namespace cansyncd
