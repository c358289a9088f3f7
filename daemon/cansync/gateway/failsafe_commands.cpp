#include "daemon/cansync/gateway/failsafe_commands.h"

#include <fmt/format.h>

#include <chrono>
#include <variant>

namespace cansyncd {
namespace {

using cansync::JobId;
using cansync::SlaveNumber;

/// Far above the numbers that clients' requests get.
constexpr JobId kFirstId = JobId{1} << 63;

/// For the audit trail, where a client's name stands otherwise.
const Requester& daemon_itself() {
  static const Requester who{"failsafe reaction", "the failsafe reaction", "", 0};
  return who;
}

}  // namespace

FailsafeCommands::FailsafeCommands(EventPublisher& events, AuditTrail& audit, const Config& config)
    : events_(events), audit_(audit) {
  if (config.failsafe.reaction != LossReaction::control_word) return;
  word_ = config.failsafe.control_word;
  slaves_ = config.failsafe.control_word_slaves.value_or(config.master.configured());
}

void FailsafeCommands::start(unsigned channel, const Config& config, SteadyTime now) {
  if (!word_ || !open_.empty()) return;
  waiting_ = open_ = slaves_;
  sent_ = {};
  failed_.clear();
  events_.publish(
      {cansync_SEVERITY_WARNING, "failsafe_control_word", -1,
       fmt::format("control word 0x{:04X} goes to {}, because the reference values of telegram {} "
                   "are missing",
                   *word_, slave_list(config, slaves_), channel + 1),
       std::nullopt},
      now);
  if (slaves_.empty()) end(config, now);
}

cansync::ControlWordRequest FailsafeCommands::request_to(SlaveNumber slave) const {
  cansync::ControlWordRequest request;
  request.id = kFirstId + slave.value();
  request.slave = slave;
  request.control_word = *word_;
  return request;
}

std::optional<SteadyTime> FailsafeCommands::push(Exchange& exchange, SteadyTime now) {
  // The realtime thread wakes nobody when it has made room.
  constexpr std::chrono::milliseconds kLookForRoom{10};
  for (std::uint8_t i = 0; i < cansync::kSlaves && !waiting_.empty(); ++i) {
    const SlaveNumber slave = *SlaveNumber::from(i);
    if (!waiting_.has(slave)) continue;
    if (!exchange.requests.try_push(request_to(slave))) return now + kLookForRoom;
    waiting_.set(slave, false);
  }
  return std::nullopt;
}

bool FailsafeCommands::finish(const Terminal& terminal, const Config& config, const RefusalContext& line,
                              SteadyTime now) {
  const JobId id = std::visit([](const auto& done) { return done.id; }, terminal);
  if (id < kFirstId) return false;
  const auto slave = SlaveNumber::from(static_cast<unsigned>(id - kFirstId));
  if (!slave || !open_.has(*slave)) return true;
  open_.set(*slave, false);
  const Request request = request_to(*slave);
  const Change change{"control_word", slave->value(), "", fmt::format("0x{:04X}", *word_)};
  std::string outcome;
  if (const auto* refused = std::get_if<Refused>(&terminal)) {
    outcome = refusal_text(refused->refusal, request, config, line);
    audit_.refused(daemon_itself(), change, &request, line.state, outcome, now);
  } else if (const auto* done = std::get_if<CommandDone>(&terminal)) {
    outcome = done->outcome == cansync::Outcome::done ? "" : std::string(cansync::name(done->outcome));
    audit_.ended(daemon_itself(), change, request, line.state, done->outcome, now);
  }
  if (outcome.empty()) {
    sent_.set(*slave);
  } else {
    failed_ += fmt::format("; not to {}: {}", slave_label(config, slave->value()), outcome);
  }
  if (open_.empty()) end(config, now);
  return true;
}

void FailsafeCommands::end(const Config& config, SteadyTime now) {
  const auto severity = failed_.empty() ? cansync_SEVERITY_INFO : cansync_SEVERITY_ERROR;
  events_.publish(
      {severity, "failsafe_control_word_ended", -1,
       fmt::format("control word 0x{:04X} was sent to {}{}", *word_, slave_list(config, sent_), failed_),
       std::nullopt},
      now);
}

}  // namespace cansyncd
