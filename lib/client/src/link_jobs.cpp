#include <fmt/format.h>

#include <algorithm>

#include "client/src/causes.h"
#include "client/src/link.h"
#include "text/counts.h"

/// Requests out, replies in.
namespace cansync::client::detail {
namespace {

static_assert(kOpenRequests == dds::kOpenRequests);

ReplyCode code_of(gateway_ReplyCode code) {
  switch (code) {
    case gateway_REPLY_DONE:
      return ReplyCode::done;
    case gateway_REPLY_REFUSED:
      return ReplyCode::refused;
    case gateway_REPLY_SLAVE_ERROR:
      return ReplyCode::slave_error;
    case gateway_REPLY_TIMEOUT:
      return ReplyCode::timeout;
    case gateway_REPLY_NO_ANSWER:
      return ReplyCode::no_answer;
    case gateway_REPLY_WORD_EXPECTED:
      return ReplyCode::word_expected;
    case gateway_REPLY_DOUBLEWORD_EXPECTED:
      return ReplyCode::doubleword_expected;
    case gateway_REPLY_VALUE_TOO_WIDE:
      return ReplyCode::value_too_wide;
    case gateway_REPLY_CANCELLED:
      return ReplyCode::cancelled;
    case gateway_REPLY_SLAVE_LOST:
      return ReplyCode::slave_lost;
    case gateway_REPLY_REPLACED:
      return ReplyCode::replaced;
    case gateway_REPLY_MASTER_STOPPED:
      break;
  }
  return ReplyCode::master_stopped;
}

/// Whose words a reply of the daemon carries.
Speaker speaker_of(ReplyCode code) {
  switch (code) {
    case ReplyCode::slave_error:
    case ReplyCode::timeout:
    case ReplyCode::no_answer:
    case ReplyCode::word_expected:
    case ReplyCode::doubleword_expected:
    case ReplyCode::value_too_wide:
    case ReplyCode::slave_lost:
      return Speaker::slave;
    default:
      return Speaker::daemon;
  }
}

template <class Sample>
void fill_common(const Sample& sample, Reply& reply) {
  reply.code = code_of(sample.code);
  reply.reason = text(sample.reason);
  reply.speaker = speaker_of(reply.code);
  reply.cause = detail::to_cause(sample.cause);
  // A daemon that is older than causes tells none.
  if (reply.code == ReplyCode::refused && reply.cause == RefusalCause::none)
    reply.cause = RefusalCause::unknown;
}

ParameterReply reply_of(const cansync_ParameterReply& sample) {
  ParameterReply reply;
  fill_common(sample, reply);
  reply.error_code = sample.error_code;
  reply.doubleword = sample.doubleword;
  reply.value = sample.value;
  reply.intervals = sample.intervals;
  return reply;
}

TransferReply reply_of(const cansync_TransferReply& sample) {
  TransferReply reply;
  fill_common(sample, reply);
  reply.error_code = sample.error_code;
  reply.error_offset = sample.error_offset;
  reply.done = sample.done;
  reply.intervals = sample.intervals;
  reply.repeated_telegrams = sample.repeated_telegrams;
  reply.repeated_blocks = sample.repeated_blocks;
  reply.data.assign(sample.data._buffer, sample.data._buffer + sample.data._length);
  return reply;
}

CommandReply reply_of(const cansync_CommandReply& sample) {
  CommandReply reply;
  fill_common(sample, reply);
  return reply;
}

cansync_ParameterFormat format_of(ParameterFormat format) {
  switch (format) {
    case ParameterFormat::word:
      return cansync_FORMAT_WORD;
    case ParameterFormat::doubleword:
      return cansync_FORMAT_DOUBLEWORD;
    case ParameterFormat::as_slave_says:
      break;
  }
  return cansync_FORMAT_AS_SLAVE_SAYS;
}

}  // namespace

template <class Sample>
bool Link::mine(const Sample& sample) const {
  return std::equal(identity_.begin(), identity_.end(), std::begin(sample.client));
}

template <class Request, class State>
void Link::address(Request& request, const State& state) const {
  std::copy(identity_.begin(), identity_.end(), std::begin(request.client));
  request.request = state.request;
  dds::set_daemon(state.daemon, request);
  dds::copy_text(options_.client_name, request.client_name);
}

template <class R>
std::shared_ptr<JobState<R>> Link::begin(OpenJobs<R>& jobs, std::chrono::milliseconds monitoring) {
  auto state = std::make_shared<JobState<R>>();
  state->link = weak_from_this();
  state->monitoring = monitoring;
  state->grace = options_.grace;
  state->since = std::chrono::steady_clock::now();
  if (!requests_) {
    state->refuse(RefusalCause::right,
                  "this client only looks (Options::requests is false); nothing was sent");
    return state;
  }
  const std::lock_guard lock(mutex_);
  const std::size_t open = parameter_jobs_.size() + transfer_jobs_.size() + command_jobs_.size();
  if (open >= kOpenRequests) {
    // The daemon would refuse it too, in these words.
    state->refuse(
        RefusalCause::client_limit,
        fmt::format("queue full: this client has {} open, at most {} are allowed; wait for a reply first",
                    text::counted(open, "request"), kOpenRequests));
    return state;
  }
  if (const auto problem = obstacle()) {
    if (problem->first == ReplyCode::refused) {
      state->refuse(RefusalCause::other_daemon, problem->second);
    } else {
      state->end(problem->first, problem->second);
    }
    return state;
  }
  state->request = ++last_request_;
  state->daemon = choice_.daemon();
  jobs.add(state);
  return state;
}

std::chrono::milliseconds Link::monitoring(std::uint32_t own_ms,
                                           std::uint32_t MasterStatus::*otherwise) const {
  if (own_ms != 0) return std::chrono::milliseconds(own_ms);
  const std::vector<MasterStatus> known = master_.known();
  return std::chrono::milliseconds(known.empty() ? 0 : known.front().*otherwise);
}

template <class R, class Request>
void Link::send(dds::Writer<Request>& writer, std::string_view topic, const Request& request,
                OpenJobs<R>& jobs, JobState<R>& state) {
  if (state.ended()) return;
  if (!writer.permitted()) {
    const std::lock_guard lock(mutex_);
    jobs.remove(state.request);
    return state.refuse(RefusalCause::right, not_permitted(topic));
  }
  const dds_return_t code = writer.write(request);
  if (code == DDS_RETCODE_OK) return;
  const std::lock_guard lock(mutex_);
  jobs.remove(state.request);
  state.refuse(
      code == DDS_RETCODE_TIMEOUT ? RefusalCause::shared_limit : RefusalCause::unknown,
      code == DDS_RETCODE_TIMEOUT
          ? "the daemon did not take the request within 1 s, nothing was sent; wait for open requests to end"
          : fmt::format("the request could not be written: {}; nothing was sent", dds_strretcode(code)));
}

std::shared_ptr<JobState<ParameterReply>> Link::submit(const ParameterRequest& request) {
  auto state = begin(parameter_jobs_, monitoring(request.timeout_ms, &MasterStatus::parameter_timeout));
  if (state->ended()) return state;
  cansync_ParameterRequest sample = {};
  address(sample, *state);
  sample.write = request.write;
  sample.slave = request.slave;
  sample.sub_slave = request.sub_slave;
  sample.number = request.number;
  sample.element = request.element;
  sample.format = format_of(request.format);
  sample.value = request.value;
  sample.timeout = request.timeout_ms;
  send(requests_->parameter_writer, "ParameterRequest", sample, parameter_jobs_, *state);
  return state;
}

std::shared_ptr<JobState<TransferReply>> Link::submit(const TransferRequest& request) {
  auto state = begin(transfer_jobs_, monitoring(request.timeout_ms, &MasterStatus::transfer_timeout));
  if (state->ended()) return state;
  if (request.data.size() > cansync_MAXIMUM_TRANSFER) {
    const std::lock_guard lock(mutex_);
    transfer_jobs_.remove(state->request);
    state->refuse(RefusalCause::length, fmt::format("length {}: out of range; allowed 1..{} bytes",
                                                    request.data.size(), cansync_MAXIMUM_TRANSFER));
    return state;
  }
  cansync_TransferRequest sample = {};
  address(sample, *state);
  sample.direction = request.download ? cansync_DIRECTION_DOWNLOAD : cansync_DIRECTION_UPLOAD;
  sample.slave = request.slave;
  sample.sub_slave = request.sub_slave;
  sample.address = request.address;
  sample.length = request.length;
  if (request.download) {
    sample.length = static_cast<std::uint32_t>(request.data.size());
    // Cyclone only reads what it writes.
    sample.data._buffer = const_cast<std::uint8_t*>(request.data.data());
    sample.data._length = sample.data._maximum = sample.length;
  }
  sample.block_size = request.block_size;
  sample.timeout = request.timeout_ms;
  send(requests_->transfer_writer, "TransferRequest", sample, transfer_jobs_, *state);
  return state;
}

std::shared_ptr<JobState<CommandReply>> Link::submit(cansync_Command command) {
  auto state = begin(command_jobs_,
                     std::max(kCommandTime, monitoring(command.timeout, &MasterStatus::command_timeout)));
  if (state->ended()) return state;
  address(command, *state);
  if (requests_->engineer_writer && dds::for_engineers(command.kind))
    send(*requests_->engineer_writer, dds::kEngineerCommandTopic.name, command, command_jobs_, *state);
  else
    send(requests_->command_writer, "Command", command, command_jobs_, *state);
  return state;
}

bool Link::cancel(std::uint64_t request) {
  gateway_JobCancel sample = {};
  {
    const std::lock_guard lock(mutex_);
    const auto name = [&](const auto& job) {
      if (job) dds::set_daemon(job->daemon, sample);
      return job != nullptr;
    };
    const bool open = name(parameter_jobs_.find(request)) || name(transfer_jobs_.find(request)) ||
                      name(command_jobs_.find(request));
    if (!open) return true;  // there is nothing to cancel any more
  }
  std::copy(identity_.begin(), identity_.end(), std::begin(sample.client));
  sample.request = request;
  return requests_ && requests_->cancel_writer.write(sample) == DDS_RETCODE_OK;
}

void Link::take_progress() {
  (void)requests_->progress_reader.take([&](const cansync_TransferProgress& sample) {
    if (!mine(sample)) return;
    std::shared_ptr<JobState<TransferReply>> job;
    {
      const std::lock_guard lock(mutex_);
      job = transfer_jobs_.find(sample.request);
    }
    if (!job) return;
    {
      const std::lock_guard lock(job->mutex);
      job->since = std::chrono::steady_clock::now();
      // A sign that the daemon has it; of one whose turn has not come, programs hear it.
      if (sample.done == job->done && sample.done != 0) return;
      job->done = sample.done;
      job->total = sample.total;
      ++job->progress;
    }
    job->changed.notify_all();
  });
}

void Link::take_command_replies() {
  std::vector<std::pair<std::shared_ptr<JobState<CommandReply>>, CommandReply>> ended;
  (void)requests_->command_reader.take([&](const cansync_CommandReply& sample) {
    if (!mine(sample)) return;
    const std::lock_guard lock(mutex_);
    if (auto job = command_jobs_.remove(sample.request)) ended.emplace_back(std::move(job), reply_of(sample));
  });
  if (ended.empty()) return;
  // The daemon tells the number of a changed mapping before the reply: whoever has the reply knows it too.
  master_.take();
  master_.tell();
  for (auto& [job, reply] : ended) job->finish(std::move(reply));
}

void Link::take_transfer_replies() {
  std::vector<std::pair<std::shared_ptr<JobState<TransferReply>>, TransferReply>> ended;
  (void)requests_->transfer_reader.take([&](const cansync_TransferReply& sample) {
    if (!mine(sample)) return;
    const std::lock_guard lock(mutex_);
    if (auto job = transfer_jobs_.find(sample.request)) ended.emplace_back(std::move(job), reply_of(sample));
  });
  if (ended.empty()) return;
  // The daemon tells the last progress before the reply: whoever waits hears it before, too.
  take_progress();
  for (auto& [job, reply] : ended) {
    std::unique_lock lock(mutex_);
    transfer_jobs_.remove(job->request);
    lock.unlock();
    job->finish(std::move(reply));
  }
}

void Link::take_replies() {
  take_progress();
  (void)requests_->parameter_reader.take([&](const cansync_ParameterReply& sample) {
    if (!mine(sample)) return;
    std::unique_lock lock(mutex_);
    const auto job = parameter_jobs_.remove(sample.request);
    lock.unlock();
    if (job) job->finish(reply_of(sample));
  });
  take_transfer_replies();
  take_command_replies();
}

}  // namespace cansync::client::detail
