#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <utility>

#include "daemon/cansync/requests/gateway_requests.h"
#include "daemon/cansync/texts/refusal_text.h"
#include "daemon/desk/gateway_jobs.h"

/// Answers on their way out; requests are in gateway_jobs.cpp.
namespace cansyncd {
namespace {

namespace dds = cansync::dds;
using cansync::SlaveMask;

/// Puts the slave's name into the reason, where it matters.
template <class Reply>
void name_slave(Reply& reply, cansync::Outcome outcome, const Request& request, const Config& config) {
  if (const std::string text = outcome_text(outcome, request, config); !text.empty()) {
    dds::copy_text(text, reply.reason);
  }
}

/// The control word in a request, to one slave or to many.
std::optional<cansync::ActionCommand> action_of(const Request& request) {
  if (const auto* word = std::get_if<cansync::ControlWordRequest>(&request)) {
    return cansync::ActionCommand{SlaveMask::of(word->slave), cansync::kCommandControlWord, 0,
                                  word->control_word};
  }
  const auto* broadcast = std::get_if<cansync::BroadcastRequest>(&request);
  if (broadcast == nullptr || broadcast->action.command != cansync::kCommandControlWord) return std::nullopt;
  return broadcast->action;
}

}  // namespace

void JobDesk::finish(const Terminal& terminal, const JobContext& context) {
  const cansync::JobId id = std::visit([](const auto& done) { return done.id; }, terminal);
  const auto found = jobs_.find(id);
  if (found == jobs_.end()) return;
  std::visit([&](const auto& done) { reply(found->second, done, context); }, terminal);
  erase(found, context.now);
}

void JobDesk::reply(Job& job, const ParameterDone& done, const JobContext& context) {
  record_end(job, done.result.outcome, context);
  if (const auto* request = std::get_if<cansync::ParameterRequest>(&job.request)) {
    audit_.learn(*request, done.result);
  }
  auto reply = dds::parameter_reply(job.key, done.result);
  name_slave(reply, done.result.outcome, job.request, context.config);
  parameter_replies_.send(reply, job.place, context.now);
}

void JobDesk::reply(Job& job, const TransferDone& done, const JobContext& context) {
  record_end(job, done.result.outcome, context);
  const auto* request = std::get_if<cansync::TransferRequest>(&job.request);
  std::span<std::uint8_t> data;
  if (request != nullptr && request->direction == cansync::TransferRequest::Direction::upload) {
    data = std::span(job.data).first(std::min<std::size_t>(job.data.size(), done.result.bytes));
  }
  // The reply borrows the data, so both go together.
  auto reply = dds::transfer_reply(job.key, done.result, data);
  name_slave(reply, done.result.outcome, job.request, context.config);
  count_data(job, job.data.size());
  transfer_replies_.send(reply, job.place, context.now, std::move(job.data));
  job.data = {};
}

void JobDesk::reply(Job& job, const CommandDone& done, const JobContext& context) {
  record_end(job, done.outcome, context);
  if (job.kind == Kind::internal) return;
  auto reply = dds::command_reply(job.key, done.outcome);
  name_slave(reply, done.outcome, job.request, context.config);
  command_replies_.send(reply, job.place, context.now);
}

void JobDesk::reply(Job& job, const Refused& refused, const JobContext& context) {
  refuse(job, Rejection::state, refusal_text(refused.refusal, job.request, context.config, context.line),
         context);
}

void JobDesk::end(Job& job, cansync::Outcome outcome, const JobContext& context) {
  record_end(job, outcome, context);
  switch (job.kind) {
    case Kind::parameter: {
      cansync::ParameterResult result;
      result.outcome = outcome;
      parameter_replies_.send(dds::parameter_reply(job.key, result), job.place, context.now);
      break;
    }
    case Kind::transfer: {
      cansync::TransferResult result;
      result.outcome = outcome;
      transfer_replies_.send(dds::transfer_reply(job.key, result, {}), job.place, context.now);
      break;
    }
    case Kind::command:
      command_replies_.send(dds::command_reply(job.key, outcome), job.place, context.now);
      break;
    case Kind::internal:
      break;
  }
}

void JobDesk::progress(const TransferProgress& report, SteadyTime now) {
  const auto found = jobs_.find(report.id);
  if (found == jobs_.end() || found->second.kind != Kind::transfer) return;
  Job& job = found->second;
  job.done = report.bytes;
  if (now < job.next_progress) return;
  job.next_progress = now + kProgressPeriod;
  const auto total = static_cast<std::uint32_t>(job.data.size());
  (void)progress_.write(dds::transfer_progress(job.key, report.bytes, total));
}

std::optional<SteadyTime> JobDesk::show_open_transfers(SteadyTime now) {
  if (transfer_bytes_ == 0) return std::nullopt;
  if (now < next_sign_) return next_sign_;
  next_sign_ = now + kSignPeriod;
  for (const auto& [id, job] : jobs_) {
    if (job.kind != Kind::transfer) continue;
    (void)progress_.write(
        dds::transfer_progress(job.key, job.done, static_cast<std::uint32_t>(job.data.size())));
  }
  return next_sign_;
}

void JobDesk::count_data(const Job& job, std::size_t ended) {
  transfer_bytes_ -= ended;
  if (ClientEntry* client = clients_.find(job.key.client)) client->transfer_bytes -= ended;
}

void JobDesk::erase(Jobs::iterator job, SteadyTime now) {
  lanes_.remove(job->first);
  const auto key = job->second.key;
  const bool internal = job->second.kind == Kind::internal;
  if (!internal) count_data(job->second, job->second.data.size());
  jobs_.erase(job);
  if (internal) return;
  open_.erase({key.client, key.request});
  ClientEntry* client = clients_.find(key.client);
  if (--client->open == 0 && client->gone) forget(key.client, now);
}

void JobDesk::cancel(Jobs::iterator job, const JobContext& context) {
  if (lanes_.waits(job->first)) {
    end(job->second, cansync::Outcome::cancelled, context);
    return erase(job, context.now);
  }
  job->second.cancel_wanted = true;
  cancels_waiting_ = true;
}

std::array<dds_entity_t, JobDesk::kReaders> JobDesk::reader_handles() const {
  return {parameters_.handle(), transfers_.handle(), commands_.handle(), cancels_.handle(),
          engineer_commands_ ? engineer_commands_->handle() : cancels_.handle()};
}

void JobDesk::replace_waiting(SlaveMask words, SlaveMask stopped, const JobContext& context) {
  for (auto next = jobs_.begin(); next != jobs_.end();) {
    const auto job = next++;
    const auto action = action_of(job->second.request);
    if (!action || !lanes_.waits(job->first)) continue;
    const bool word = std::holds_alternative<cansync::ControlWordRequest>(job->second.request);
    const bool enables = cansync::enables(context.config.master.startup, action->data_word);
    if ((!word || (action->slaves.bits & words.bits) == 0) &&
        (!enables || (action->slaves.bits & stopped.bits) == 0)) {
      continue;
    }
    end(job->second, cansync::Outcome::replaced, context);
    erase(job, context.now);
  }
}

/// Clients take turns in a lane: without this, what was given earlier could go out later.
void JobDesk::replace_waiting(const Request& newer, const JobContext& context) {
  const auto action = action_of(newer);
  if (!action) return;
  const bool word = std::holds_alternative<cansync::ControlWordRequest>(newer);
  const bool enables = cansync::enables(context.config.master.startup, action->data_word);
  if (word || !enables)
    replace_waiting(word ? action->slaves : SlaveMask{}, enables ? SlaveMask{} : action->slaves, context);
}

void JobDesk::look_for_clients(const JobContext& context) {
  const std::array<dds_entity_t, kReaders> readers = reader_handles();
  if (living_.look(readers, places_)) {
    for (std::size_t i = 0; i < kReaders; ++i) guards_[i].keep(living_.writers(i));
  }
  for (const ClientIdentity& identity : clients_.mark_gone(living_)) {
    const ClientEntry client = *clients_.find(identity);
    if (client.open == 0) {
      forget(identity, context.now);
      continue;
    }
    const auto is_its = [&](const auto& job) {
      return job.second.kind != Kind::internal && job.second.key.client == identity;
    };
    const auto any = std::find_if(jobs_.begin(), jobs_.end(), is_its);
    const std::string name = any == jobs_.end() ? client.who : any->second.who.name;
    events_.publish({gateway_SEVERITY_WARNING, "client_gone", -1,
                     fmt::format("{} is gone; its {} open requests are cancelled", client.who, client.open),
                     std::nullopt, std::nullopt, name},
                    context.now);
    for (auto job = jobs_.begin(); job != jobs_.end();) {
      const auto here = job++;
      if (is_its(*here)) cancel(here, context);
    }
  }
}

void JobDesk::forget(const ClientIdentity& identity, SteadyTime now) {
  clients_.erase(identity);
  const auto forget_in = [&](auto& outbox, auto key) {
    std::copy(identity.begin(), identity.end(), std::begin(key.client));
    outbox.forget(key, now);
  };
  forget_in(parameter_replies_, cansync_ParameterReply{});
  forget_in(transfer_replies_, cansync_TransferReply{});
  forget_in(command_replies_, cansync_CommandReply{});
  cansync_TransferProgress progress = {};
  std::copy(identity.begin(), identity.end(), std::begin(progress.client));
  (void)progress_.unregister(progress);
}

void JobDesk::record_end(const Job& job, cansync::Outcome outcome, const JobContext& context) {
  std::optional<Change> change = job.change;
  if (change && !job.data.empty()) change->new_value = data_text(job.data.data(), job.data.size());
  if (job.kind == Kind::internal) {
    change = Change{"configuration", -1, "", describe(job.request, context.config).value_or("")};
  }
  audit_.ended(job.who, change, job.request, job.state_before, outcome, context.now);
}

void JobDesk::stop(const JobContext& context) {
  stopping_ = true;
  // Clients that write without a rest must not keep the daemon from stopping.
  constexpr int kLooks = 64;
  for (int look = 0; look < kLooks && take_requests(context); ++look) {
  }
  for (auto& [id, job] : jobs_) {
    end(job, cansync::Outcome::master_stopped, context);
    if (!job.data.empty()) abandoned_.push_back(std::move(job.data));
  }
  jobs_.clear();
  lanes_ = FairLanes(lane_limits(context.config.master.command_channel));
  open_.clear();
  transfer_bytes_ = 0;
}

void JobDesk::wait_for_readers(dds_duration_t time) const noexcept {
  parameter_replies_.wait_for_readers(time);
  transfer_replies_.wait_for_readers(time);
  command_replies_.wait_for_readers(time);
}

}  // namespace cansyncd
