#include "writers.h"

#include <algorithm>
#include <utility>
#include <variant>

namespace cansyncd::campaign {

using cansync::Channel;

namespace {

/// After it a writer that died is noticed, in intervals.
constexpr std::uint64_t kLease = 15;
constexpr DaemonIdentity kThisStart = {1};
constexpr DaemonIdentity kStartBefore = {2};

Config config_of(const Plan& plan) {
  Config config;
  config.master = plan.settings;
  config.failsafe.reaction = plan.writers.hold != 0 ? LossReaction::hold : LossReaction::stop_release;
  config.failsafe.hold_intervals = std::max(plan.writers.hold, 1u);
  config.failsafe.reference_max_age = plan.writers.maximum_age;
  config.failsafe.reference_deadline = plan.writers.deadline;
  return config;
}

}  // namespace

Writers::Writers(const Plan& plan, Exchange& exchange, sim::Line& line, ReferenceTruth& truth, Tamper* tamper)
    : plan_(plan),
      exchange_(exchange),
      line_(line),
      truth_(truth),
      tamper_(tamper),
      dice_(plan.seed ^ 0x3817E5),
      gate_(kThisStart, config_of(plan), *this, std::nullopt) {
  for (const std::int32_t strength : plan.writers.strengths) {
    Program program;
    program.handle = ++last_handle_;
    program.runs = true;
    program.strength = strength;
    // Who wrote to the daemon before goes on as if nothing had happened.
    program.of_daemon_before = dice_.chance(400);
    program.holds.fill(program.of_daemon_before);
    programs_.push_back(program);
  }
}

// --- the programs

void Writers::live(std::uint64_t interval, std::uint64_t mapping_number) {
  for (unsigned i = 0; i < programs_.size(); ++i) live_one(i, interval, mapping_number);
}

void Writers::live_one(unsigned number, std::uint64_t interval, std::uint64_t mapping_number) {
  Program& program = programs_[number];
  if (!program.runs) {
    if (program.handle != 0 && line_.intervals() >= program.noticed_at) {
      dead_.push_back(std::exchange(program.handle, 0));
      program.holds = {};
    }
    if (program.handle == 0 && dice_.chance(30)) {
      program.runs = true;
      program.handle = ++last_handle_;
      program.of_daemon_before = false;
      program.mapping_number = mapping_number;
    }
    return;
  }
  if (dice_.chance(4)) {
    program.runs = false;
    program.noticed_at = line_.intervals() + kLease;
    return;
  }
  if (dice_.chance(program.of_daemon_before ? 10 : 300)) {  // it takes its telegrams up again
    program.of_daemon_before = false;
    program.mapping_number = mapping_number;
  }
  for (const Channel channel : {Channel::one, Channel::two}) {
    bool& holds = program.holds[index(channel)];
    if (holds && dice_.chance(15)) {
      give_up(number, channel);
    } else if (dice_.chance(holds ? plan_.mix.references : 20)) {
      holds = true;
      write(number, channel, interval, false);
    }
  }
}

void Writers::settle_down(std::uint64_t interval, std::uint64_t mapping_number) {
  for (unsigned i = 1; i < programs_.size(); ++i) {
    Program& program = programs_[i];
    if (program.handle != 0) dead_.push_back(std::exchange(program.handle, 0));
    program.runs = false;
    program.holds = {};
  }
  Program& last = programs_.front();
  if (last.handle == 0) last.handle = ++last_handle_;
  last.runs = true;
  last.of_daemon_before = false;
  last.mapping_number = mapping_number;
  for (const Channel channel : {Channel::one, Channel::two}) {
    last.holds[index(channel)] = true;
    write(0, channel, interval, true);
  }
}

/// DDS lets nobody else's samples through. One that has died counts until that is noticed.
const Writers::Program* Writers::strongest(Channel channel) const noexcept {
  const Program* found = nullptr;
  for (const Program& program : programs_) {
    if (program.handle == 0 || !program.holds[index(channel)]) continue;
    if (found == nullptr || program.strength > found->strength ||
        (program.strength == found->strength && program.handle < found->handle)) {
      found = &program;
    }
  }
  return found;
}

void Writers::write(unsigned number, Channel channel, std::uint64_t interval, bool steady) {
  const Program& program = programs_[number];
  Sample written{{}, number, program.of_daemon_before};
  ReferenceSample& sample = written.sample;
  sample.writer = program.handle;
  sample.telegram = index(channel) + 1;
  sample.written = wall();
  sample.daemon = program.of_daemon_before ? kStartBefore : kThisStart;
  cansync::ReferenceUpdate& update = sample.update;
  update.channel = channel;
  update.mapping_number = program.mapping_number;
  update.valid_mask = 0x0F;
  if (!steady) {
    if (dice_.chance(50)) sample.problem = gateway::dds::Denial{gateway_CAUSE_FIELD, "out of range"};
    if (dice_.chance(100)) update.release_intervals = static_cast<std::uint32_t>(dice_.between(2, 30));
    if (dice_.chance(100)) update.from_interval = interval + dice_.between(1, 40);
  }
  send(std::move(written), channel);
}

void Writers::give_up(unsigned number, Channel channel) {
  Program& program = programs_[number];
  Sample written{{}, number, program.of_daemon_before};
  written.sample.writer = program.handle;
  written.sample.telegram = index(channel) + 1;
  written.sample.given_up = true;
  written.sample.written = wall();
  send(std::move(written), channel);
  program.holds[index(channel)] = false;
}

void Writers::send(Sample written, Channel channel) {
  if (strongest(channel)->handle != written.sample.writer) return;
  auto& kept = samples_[index(channel)];
  if (kept.size() == kKept) kept.pop_front();
  kept.push_back(std::move(written));
}

// --- the gateway

void Writers::gateway(const MasterSnapshot& now) {
  gate_.set_line(now.when);
  gate_.watch(now.release, steady());
  for (auto& kept : samples_) {
    for (; !kept.empty(); kept.pop_front()) deliver(kept.front());
  }
  for (const WriterHandle handle : std::exchange(dead_, {})) {
    for (unsigned channel = 0; channel < cansync::kChannels; ++channel) {
      if (gate_.owner(channel) == handle) gate_.lost(channel, steady());
    }
  }
  gate_.tick(steady());
  gate_.push_stops();
  if (exchange_.requests.size() < exchange_.requests.capacity()) truth_.stops_handed_on();
}

void Writers::deliver(const Sample& sample) {
  ReferenceSample seen = sample.sample;
  const Channel channel = seen.telegram == 1 ? Channel::one : Channel::two;
  if (seen.given_up) {
    truth_.gave_up(channel, sample.program);
  } else if (gate_.owner(index(channel)) != 0 || plan_.writers.hold == 0) {
    // The hold of a lost writer's values goes on until there are others that can be taken.
    truth_.taken_over(channel, sample.program);
  }
  if (tamper_ != nullptr) tamper_->sample(seen, kThisStart);
  current_ = &sample;
  gate_.take(seen, wall(), steady());
  current_ = nullptr;
}

void Writers::refused(const ReferenceRefused& report) {
  gate_.refused(index(report.channel), {gateway_CAUSE_UNKNOWN, std::string(name(report.refusal))},
                report.when, steady());
}

std::string Writers::hand_on(const Request& request) {
  constexpr const char* kFull = "no room";
  if (const auto* stop = std::get_if<StopRelease>(&request)) {
    if (tamper_ != nullptr && tamper_->swallows(*stop)) return {};
    return exchange_.requests.try_push(request) ? "" : kFull;
  }
  cansync::ReferenceUpdate update = std::get<cansync::ReferenceUpdate>(request);
  const std::uint32_t number = truth_.next_number();
  update.value.fill(ReferenceTruth::value_of(number));
  if (tamper_ != nullptr) tamper_->update(update);
  if (!exchange_.requests.try_push(update)) return kFull;
  truth_.pushed(number, update,
                {current_->program, current_->of_daemon_before, can::Time(current_->sample.written)});
  if (on_event) {
    on_event("reference values " + std::to_string(number) + " of program " +
             std::to_string(current_->program) + " for telegram " +
             std::to_string(index(update.channel) + 1));
  }
  return {};
}

void Writers::tell(const EventText& event, SteadyTime /*now*/) {
  if (on_event) on_event("event " + event.text);
}

ReferenceSurroundings::Writer Writers::identify(WriterHandle writer) {
  for (const Program& program : programs_) {
    if (program.handle == writer) return {"program " + std::to_string(writer), program.strength};
  }
  return {"a program that has left", 0};
}

bool Writers::left(WriterHandle writer) {
  return std::none_of(programs_.begin(), programs_.end(),
                      [writer](const Program& program) { return program.handle == writer; });
}

}  // namespace cansyncd::campaign
