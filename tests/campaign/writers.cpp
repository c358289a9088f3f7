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

const Writers::Program* Writers::of(WriterHandle writer) const noexcept {
  const auto found = std::find_if(programs_.begin(), programs_.end(), [writer](const Program& program) {
    return writer != 0 && program.handle == writer;
  });
  return found == programs_.end() ? nullptr : &*found;
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
  auto& kept = samples_[index(channel)];
  const auto same = [&](const Sample& one) { return one.sample.writer == written.sample.writer; };
  if (std::count_if(kept.begin(), kept.end(), same) == kKept)
    kept.erase(std::find_if(kept.begin(), kept.end(), same));
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
      gate_.arbiter(channel).forget(handle);
      if (gate_.owner(channel) == handle) gate_.lost(channel, wall(), steady());
    }
  }
  gate_.tick(steady());
  gate_.push_stops();
  if (exchange_.requests.size() < exchange_.requests.capacity()) truth_.stops_handed_on();
}

void Writers::deliver(const Sample& sample) {
  ReferenceSample seen = sample.sample;
  const Channel channel = seen.telegram == 1 ? Channel::one : Channel::two;
  if (tamper_ != nullptr) tamper_->sample(seen, kThisStart);
  const WriterHandle before = gate_.owner(index(channel));
  // Of a program that starts anew and waits, it says nothing of the values that it gave before it died.
  if (seen.given_up && before == seen.writer) truth_.gave_up(channel, sample.program);
  current_ = &sample;
  handed_on_ = false;
  gate_.take(seen, wall(), steady());
  current_ = nullptr;
  judge(before, sample);
  if (gate_.owner(index(channel)) != sample.sample.writer) return;
  if (before == 0 && plan_.writers.hold != 0)
    truth_.follows_lost(channel, sample.program);
  else
    truth_.taken_over(channel, sample.program);
}

/// The rule, with the strengths that the programs have: what the gate asks for may be tampered with.
void Writers::judge(WriterHandle before, const Sample& sample) {
  const WriterHandle writer = sample.sample.writer;
  const Program* const owner = of(before);
  const Program* const other = of(writer);
  if (owner == nullptr || other == nullptr || before == writer || sample.sample.given_up) return;
  const WriterHandle after = gate_.owner(sample.sample.telegram - 1u);
  if (other->strength > owner->strength) {
    if (after != writer)
      truth_.complain_of_owner("did not come to the stronger program " + std::to_string(sample.program));
  } else if (after != before || handed_on_) {
    truth_.complain_of_owner("was taken by program " + std::to_string(sample.program) +
                             ", which is no stronger than the writer that has it");
  }
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
  handed_on_ = true;
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

gateway::dds::WriterIdentity Writers::identify(WriterHandle writer) {
  const Program* const program = of(writer);
  if (program == nullptr) return {"a program that has left"};
  std::int32_t strength = program->strength;
  const bool has_owner = current_ != nullptr && gate_.owner(current_->sample.telegram - 1u) != 0;
  if (tamper_ != nullptr && has_owner) tamper_->strength(strength);
  return {"program " + std::to_string(writer), strength};
}

bool Writers::left(WriterHandle writer) {
  return of(writer) == nullptr;
}

}  // namespace cansyncd::campaign
