#include "daemon/cansync/gateway/failsafe_commands.h"

#include <fmt/format.h>

#include <chrono>
#include <variant>

#include "cansync/channel/job_ids.h"

namespace cansyncd {
namespace {

using cansync::JobId;
using cansync::SlaveNumber;

/// For the audit trail, where a client's name stands otherwise.
const Requester& daemon_itself() {
  static const Requester who{"failsafe reaction", "the failsafe reaction", "", 0};
  return who;
}

}  // namespace

FailsafeCommands::FailsafeCommands(EventPublisher& events, RequestAudit& audit, const Config& config)
    : events_(events), audit_(audit) {
  if (config.failsafe.reaction != LossReaction::control_word) return;
  word_ = config.failsafe.control_word;
  slaves_ = config.failsafe.control_word_slaves.value_or(config.master.configured());
}

void FailsafeCommands::start(unsigned channel, const Config& config, SteadyTime now) {
  if (!word_) return;
  missing_[channel] = true;
  if (!open_.empty()) {
    if (waiting_ == slaves_) return;
    failed_ += fmt::format("; not yet to {}: a new loss begins another round", slave_list(config, open_));
    end(config, now);
  }
  ++round_;
  waiting_ = open_ = slaves_;
  to_cancel_ = sent_ = withdrawn_ = {};
  failed_.clear();
  events_.publish(
      {gateway_SEVERITY_WARNING, "failsafe_control_word", -1,
       fmt::format("control word 0x{:04X} goes to {}, because the reference values of telegram {} "
                   "are missing",
                   *word_, slave_list(config, slaves_), channel + 1),
       std::nullopt},
      now);
  if (slaves_.empty()) end(config, now);
}

void FailsafeCommands::values_back(unsigned channel, const Config& config, SteadyTime now) {
  missing_[channel] = false;
  if (open_.empty() || missing_ != std::array<bool, cansync::kChannels>{}) return;
  withdrawn_ = waiting_;
  open_ = to_cancel_ = {open_.bits & ~waiting_.bits};
  waiting_ = {};
  if (open_.empty()) end(config, now);
}

/// The answer to a word of an earlier round does not count for this one.
cansync::JobId FailsafeCommands::id_of(SlaveNumber slave, std::uint64_t round) const noexcept {
  return cansync::kFailsafeJobs + round * cansync::kSlaves + slave.value();
}

cansync::ControlWordRequest FailsafeCommands::request_to(SlaveNumber slave) const {
  cansync::ControlWordRequest request;
  request.id = id_of(slave, round_);
  request.slave = slave;
  request.control_word = *word_;
  request.failsafe = true;
  return request;
}

std::optional<SteadyTime> FailsafeCommands::push(Exchange& exchange, SteadyTime now) {
  // The realtime thread wakes nobody when it has made room.
  constexpr std::chrono::milliseconds kLookForRoom{10};
  for (std::uint8_t i = 0; i < cansync::kSlaves && !(waiting_.empty() && to_cancel_.empty()); ++i) {
    const SlaveNumber slave = *SlaveNumber::from(i);
    if (to_cancel_.has(slave)) {
      if (!exchange.requests.try_push(Cancel{id_of(slave, round_)})) return now + kLookForRoom;
      to_cancel_.set(slave, false);
    }
    if (waiting_.has(slave)) {
      if (!exchange.requests.try_push(request_to(slave))) return now + kLookForRoom;
      waiting_.set(slave, false);
    }
  }
  return std::nullopt;
}

bool FailsafeCommands::finish(const Terminal& terminal, const Config& config, const RefusalContext& line,
                              SteadyTime now) {
  const JobId id = std::visit([](const auto& done) { return done.id; }, terminal);
  if (id < cansync::kFailsafeJobs) return false;
  const SlaveNumber slave = *SlaveNumber::from((id - cansync::kFailsafeJobs) % cansync::kSlaves);
  const Request request = request_to(slave);
  const Change change{"control_word", slave.value(), "", fmt::format("0x{:04X}", *word_)};
  std::string outcome;
  bool withdrawn = false;
  if (const auto* refused = std::get_if<Refused>(&terminal)) {
    const gateway::dds::Denial denial = denial_of(refused->refusal, request, config, line);
    outcome = text_of(denial);
    audit_.refused(daemon_itself(), change, request, line.state, denial, now);
  } else if (const auto* done = std::get_if<CommandDone>(&terminal)) {
    withdrawn = done->outcome == cansync::Outcome::cancelled;
    if (done->outcome == cansync::Outcome::no_answer) {
      outcome = "handed over, but not seen on the bus";
    } else if (done->outcome != cansync::Outcome::done) {
      outcome = cansync::name(done->outcome);
    }
    audit_.ended(daemon_itself(), change, request, line.state, done->outcome, now);
  }
  if (id != id_of(slave, round_) || !open_.has(slave)) return true;
  open_.set(slave, false);
  to_cancel_.set(slave, false);
  if (withdrawn) {
    withdrawn_.set(slave);
  } else if (outcome.empty()) {
    sent_.set(slave);
  } else {
    failed_ += fmt::format("; not to {}: {}", slave_label(config, slave.value()), outcome);
  }
  if (open_.empty()) end(config, now);
  return true;
}

void FailsafeCommands::end(const Config& config, SteadyTime now) {
  const auto severity = failed_.empty() ? gateway_SEVERITY_INFO : gateway_SEVERITY_ERROR;
  std::string withdrawn;
  if (!withdrawn_.empty()) {
    withdrawn = fmt::format("; not to {}: new reference values came first", slave_list(config, withdrawn_));
  }
  events_.publish({severity, "failsafe_control_word_ended", -1,
                   fmt::format("control word 0x{:04X} was sent to {}{}{}", *word_, slave_list(config, sent_),
                               withdrawn, failed_),
                   std::nullopt},
                  now);
}

}  // namespace cansyncd
