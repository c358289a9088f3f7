#include "daemon/cansync/gateway/reference_gate.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "cansync/settings/timing.h"
#include "daemon/cansync/texts/refusal_text.h"
#include "text/counts.h"

namespace cansyncd {
namespace {

using gateway::dds::Denial;

cansync::Channel channel_of(unsigned index) noexcept {
  return index == 0 ? cansync::Channel::one : cansync::Channel::two;
}

constexpr std::string_view kTakeUp =
    "look at the line, then let the program take up its telegrams (ReferenceWriter::take_up), or start it "
    "again";

}  // namespace

ReferenceGate::ReferenceGate(const DaemonIdentity& daemon, const Config& config,
                             ReferenceSurroundings& around, gateway::dds::Problem refusal)
    : daemon_(daemon),
      age_(config.failsafe.reference_max_age, cansync::slot_times(config.master.bit_rate).interval),
      hold_(config.failsafe.reaction == LossReaction::hold ? config.failsafe.hold_intervals : 0),
      deadline_(config.failsafe.reference_deadline),
      around_(around),
      refusal_(std::move(refusal)) {
  set_limits(config);
}

void ReferenceGate::set_limits(const Config& config) noexcept {
  for (unsigned value = 0; value < cansync::kValues; ++value) {
    Telegram& telegram = telegrams_[value / cansync::kWords];
    if (value % cansync::kWords == 0) telegram.limited = false;
    telegram.limited = telegram.limited || config.master.process.reference_limits[value].any();
  }
}

void ReferenceGate::set_refusal(gateway::dds::Problem refusal) {
  if (refusal && !refusal_) {
    for (unsigned channel = 0; channel < cansync::kChannels; ++channel) stop(channel, 0);
  }
  refusal_ = std::move(refusal);
}

void ReferenceGate::set_lead_axis(const std::array<bool, cansync::kChannels>& gives) noexcept {
  for (unsigned channel = 0; channel < cansync::kChannels; ++channel) {
    if (!gives[channel] || lead_axis_[channel]) continue;
    // What came before this was known has been refused, too.
    arbiters_[channel].free();
    givers_[channel] = {};
  }
  lead_axis_ = gives;
}

void ReferenceGate::take(const ReferenceSample& sample, std::int64_t wall, SteadyTime now) {
  const bool known_telegram = sample.telegram == 1 || sample.telegram == 2;
  // A key that is no telegram still needs a place to be counted.
  const unsigned channel = sample.telegram == 2 ? 1 : 0;
  if (sample.given_up) {
    if (!known_telegram) return;
    arbiters_[channel].forget(sample.writer);
    if (owner(channel) == sample.writer) given_up(channel, std::min(sample.written, wall), now);
    return;
  }
  if (!known_telegram) {
    refused(channel, sample.problem.value_or(Denial{gateway_CAUSE_FIELD, "no such telegram"}), std::nullopt,
            now);
    return;
  }
  if (lead_axis_[channel]) {
    refused(channel, lead_axis_denial(), std::nullopt, now);
    return;
  }
  take_values(sample, channel, wall, now);
}

void ReferenceGate::take_values(const ReferenceSample& sample, unsigned channel, std::int64_t wall,
                                SteadyTime now) {
  Telegram& telegram = telegrams_[channel];
  TopicWriter writer{sample.writer, sample.key};
  if (owner(channel) != sample.writer) writer.identity = around_.identify(sample.writer);
  const WriterArbiter::Claim claim = arbiters_[channel].claim(sample.writer, writer.identity.strength);
  if (claim == WriterArbiter::Claim::waits) return wait(channel, writer, now);
  const bool takes_over = claim == WriterArbiter::Claim::takes_over;

  const ReferenceAge::Verdict age = age_.judge(sample.written, {now, wall});
  gateway::dds::Problem denied = problem(sample, age, wall);
  push_stops();
  if (!denied && telegram.stop_wanted) {
    denied = Denial{gateway_CAUSE_QUEUE_FULL, "request queue full: the stop of its release waits for room"};
  }
  if (!denied) {
    cansync::ReferenceUpdate update = sample.update;
    update.channel = channel_of(channel);
    update.takes_over = takes_over;
    update.too_old_from = age.too_old_from;
    if (std::string full = around_.hand_on(update); !full.empty()) {
      denied = Denial{gateway_CAUSE_QUEUE_FULL, std::move(full)};
    } else {
      telegram.newest = update;
    }
  }
  if (takes_over || (claim == WriterArbiter::Claim::begins && !denied)) new_owner(channel, writer, now);
  if (denied) {
    // A take-over counts whatever its first values are refused for.
    if (takes_over) stop(channel, 0);
    push_stops();
    refused(channel, *denied, std::nullopt, now);
    return;
  }
  if (!telegram.released && !telegram.beyond_limit) begin_deadline(telegram, now);
  if (!telegram.limited) values_given(channel);
}

void ReferenceGate::begin_deadline(Telegram& telegram, SteadyTime now) noexcept {
  telegram.given = now;
  telegram.deadline_missed = false;
}

void ReferenceGate::values_given(unsigned channel) {
  Telegram& telegram = telegrams_[channel];
  telegram.returned = telegram.returned || telegram.reacted;
  telegram.reacted = false;
  givers_[channel].loss = Loss::none;
}

void ReferenceGate::wait(unsigned channel, const TopicWriter& writer, SteadyTime now) {
  WriterArbiter& arbiter = arbiters_[channel];
  std::string text = arbiter.refuse(writer);
  if (!text.empty())
    tell(gateway_SEVERITY_WARNING, "writer_waits", std::move(text), writer.identity.who, now);
}

void ReferenceGate::tell_waiting(unsigned channel) {
  const WriterArbiter& arbiter = arbiters_[channel];
  ReferenceGiver& giver = givers_[channel];
  if (giver.waiting != arbiter.waiting()) giver.waiting = arbiter.waiting();
  if (giver.refused != arbiter.refused()) giver.refused_reason = arbiter.refused_reason();
  giver.refused = arbiter.refused();
}

void ReferenceGate::new_owner(unsigned channel, const TopicWriter& writer, SteadyTime now) {
  Telegram& telegram = telegrams_[channel];
  ReferenceGiver& giver = givers_[channel];
  const gateway::dds::WriterIdentity& facts = writer.identity;
  if (owner(channel) != 0) {
    tell(gateway_SEVERITY_WARNING, "reference_writer_taken_over",
         fmt::format("{} (strength {}) has taken over the reference values of telegram {} from {} (strength "
                     "{}){}",
                     facts.who, facts.strength, channel + 1, giver.who, giver.strength,
                     around_.left(owner(channel)) ? ", which has left" : ""),
         facts.who, now);
  } else {
    tell(gateway_SEVERITY_INFO, "reference_writer_began",
         fmt::format("{} (strength {}) gives the reference values of telegram {}", facts.who, facts.strength,
                     channel + 1),
         facts.who, now);
  }
  giver.who = facts.who;
  giver.strength = facts.strength;
  giver.guid = facts.guid;
  arbiters_[channel].give(writer);
  begin_deadline(telegram, now);
}

gateway::dds::Problem ReferenceGate::problem(const ReferenceSample& sample, const ReferenceAge::Verdict& age,
                                             std::int64_t wall) const {
  if (sample.problem) return sample.problem;
  if (refusal_) return refusal_;
  if (sample.daemon == DaemonIdentity{}) {
    return Denial{
        gateway_CAUSE_OTHER_DAEMON,
        "daemon: not given; write MasterStatus.daemon and MasterStatus.mapping_number into it, as libcansync "
        "of this version does"};
  }
  if (sample.daemon != daemon_) {
    return Denial{
        gateway_CAUSE_OTHER_DAEMON,
        fmt::format(
            "daemon {:02x}: the values are meant for another start of the daemon, and settings made before it "
            "may be lost; {}",
            fmt::join(sample.daemon, ""), kTakeUp)};
  }
  if (mapping_number_ && sample.update.mapping_number != *mapping_number_)
    return mapping_denial(sample.update.mapping_number, *mapping_number_);
  if (age.problem || !age_.looked_at()) return age.problem;
  const std::int64_t not_before = telegrams_[sample.telegram - 1].not_before;
  // A wall clock that was set back since then tells nothing about it.
  if (sample.written >= not_before || wall < not_before) return std::nullopt;
  return Denial{
      gateway_CAUSE_STALE,
      fmt::format(
          "written {} ms before the telegram was given up by its writer then, or that was lost; write fresh "
          "values, and set the clocks of the computers",
          (not_before - sample.written) / 1'000'000)};
}

void ReferenceGate::given_up(unsigned channel, std::int64_t written, SteadyTime now) {
  Telegram& telegram = telegrams_[channel];
  telegram.not_before = written;
  stop(channel, 0);
  const std::string who = givers_[channel].who;
  tell(gateway_SEVERITY_INFO, "reference_given_up",
       fmt::format("{} has given the reference values of telegram {} up; their release is stopped until new "
                   "ones come",
                   who, channel + 1),
       who, now);
  end_ownership(channel, Loss::given_up);
}

void ReferenceGate::lost(unsigned channel, std::int64_t wall, SteadyTime now) {
  if (owner(channel) == 0) return;
  telegrams_[channel].not_before = wall;
  stop(channel, hold_);
  const std::string who = givers_[channel].who;
  tell(gateway_SEVERITY_WARNING, "reference_writer_lost",
       fmt::format("{}, which gave the reference values of telegram {}, has left or died; {}", who,
                   channel + 1, reaction_text()),
       who, now);
  end_ownership(channel, Loss::writer_lost);
}

void ReferenceGate::end_ownership(unsigned channel, Loss loss) {
  arbiters_[channel].free();
  ReferenceGiver& giver = givers_[channel];
  // Who waits, and what was refused why, is no matter of the owner.
  giver.who.clear();
  giver.strength = 0;
  giver.guid = {};
  lose(channel, loss);
  push_stops();
}

void ReferenceGate::watch(const std::array<cansync::ReleaseStatus, cansync::kChannels>& release,
                          SteadyTime now) {
  for (unsigned channel = 0; channel < cansync::kChannels; ++channel) {
    Telegram& telegram = telegrams_[channel];
    const bool given = std::exchange(telegram.updates, release[channel].updates) != release[channel].updates;
    telegram.released = release[channel].state == cansync::ReleaseStatus::State::released;
    if (given) {
      telegram.beyond_limit = false;
      begin_deadline(telegram, now);
    }
    // Values of the lead axis do not come through here, and others may be beyond a limit. When they ended, too,
    // since the last look, those that are released now came after that.
    const bool decided_there = lead_axis_[channel] || telegram.limited;
    if (decided_there && given) values_given(channel);
    // The realtime thread has stopped it already, and told what grew too old. Without a writer it was left over
    // from the one that was lost: that is the cause.
    const bool left_over = !lead_axis_[channel] && owner(channel) == 0 && givers_[channel].loss != Loss::none;
    if (std::exchange(telegram.too_old, release[channel].too_old) != release[channel].too_old && !left_over)
      lose(channel, Loss::too_old);
    if (decided_there && given && telegram.released) values_given(channel);
    const std::uint64_t changed = release[channel].mapping_changed;
    if (std::exchange(telegram.mapping_changed, changed) == changed) continue;
    // A mapping of the other telegram's values; the next values of the lead axis are for it.
    if (lead_axis_[channel]) continue;
    const std::string who = givers_[channel].who;
    tell(gateway_SEVERITY_WARNING, "reference_mapping_changed",
         fmt::format("the mapping of the reference values was changed while those of telegram {} were "
                     "released{}{}; their release is stopped; {}",
                     channel + 1, who.empty() ? "" : ", given by ", who, kTakeUp),
         who, now);
    lose(channel, Loss::mapping_changed);
  }
}

void ReferenceGate::stop(unsigned channel, std::uint32_t hold) {
  std::optional<std::uint32_t>& wanted = telegrams_[channel].stop_wanted;
  wanted = std::min(wanted.value_or(hold), hold);
}

void ReferenceGate::lose(unsigned channel, Loss loss) {
  Telegram& telegram = telegrams_[channel];
  givers_[channel].loss = loss;
  telegram.reaction_due = telegram.reaction_due || !telegram.reacted;
  telegram.returned = false;
  telegram.reacted = true;
}

bool ReferenceGate::take_reaction(unsigned channel) noexcept {
  return std::exchange(telegrams_[channel].reaction_due, false);
}

bool ReferenceGate::take_return(unsigned channel) noexcept {
  return std::exchange(telegrams_[channel].returned, false);
}

std::string ReferenceGate::reaction_text() const {
  if (hold_ == 0) return "their release is stopped until new ones come";
  return fmt::format("their release is stopped after at most {} until new ones come",
                     text::counted(hold_, "interval"));
}

std::optional<SteadyTime> ReferenceGate::look_at_deadline(unsigned channel, SteadyTime now) {
  Telegram& telegram = telegrams_[channel];
  if (deadline_.count() == 0 || owner(channel) == 0) return std::nullopt;
  if (telegram.deadline_missed) return std::nullopt;
  if (now < telegram.given + deadline_) return telegram.given + deadline_;
  telegram.deadline_missed = true;
  stop(channel, hold_);
  tell(gateway_SEVERITY_WARNING, "reference_deadline_missed",
       fmt::format("{} lives, but has given no new reference values of telegram {} for {} ms "
                   "(failsafe.reference_deadline_ms); {}",
                   givers_[channel].who, channel + 1, deadline_.count(), reaction_text()),
       givers_[channel].who, now);
  lose(channel, Loss::deadline_missed);
  return std::nullopt;
}

void ReferenceGate::push_stops() {
  for (unsigned channel = 0; channel < cansync::kChannels; ++channel) {
    auto& wanted = telegrams_[channel].stop_wanted;
    if (wanted && around_.hand_on(StopRelease{channel_of(channel), refusal_ ? 0 : *wanted}).empty())
      wanted.reset();
  }
}

void ReferenceGate::refused_for_limit(unsigned channel, const Denial& denial, std::optional<Moment> when,
                                      SteadyTime now) {
  telegrams_[channel].beyond_limit = true;
  givers_[channel].refused_reason = denial.reason;
  refused(channel, denial, when, now);
}

void ReferenceGate::refused(unsigned channel, const Denial& denial, std::optional<Moment> when,
                            SteadyTime now) {
  Telegram& telegram = telegrams_[channel];
  if (!telegram.refused.add(1, now)) return;
  telegram.reason = text_of(denial);
  EventText event{
      gateway_SEVERITY_WARNING, "reference_refused", -1,
      fmt::format("reference values of telegram {} are refused: {}", channel + 1, telegram.reason), when};
  around_.tell(event, now);
}

std::optional<SteadyTime> ReferenceGate::tick(SteadyTime now) {
  std::optional<SteadyTime> next;
  for (unsigned channel = 0; channel < cansync::kChannels; ++channel) {
    Telegram& telegram = telegrams_[channel];
    tell_waiting(channel);
    const std::uint64_t refused = telegram.refused.take_over(now);
    for (const auto due : {telegram.refused.next(), look_at_deadline(channel, now)}) {
      if (due) next = next ? std::min(*next, *due) : *due;
    }
    if (refused == 0) continue;
    tell(gateway_SEVERITY_INFO, "reference_refusals_over",
         fmt::format("no reference values of telegram {} were refused for {} s; {} were before, the first "
                     "because of {}",
                     channel + 1, kQuiet.count(), refused, telegram.reason),
         {}, now);
  }
  return next;
}

void ReferenceGate::tell(gateway_EventSeverity severity, EventCode code, std::string text,
                         const std::string& who, SteadyTime now) {
  EventText event{severity, code, -1, std::move(text), std::nullopt};
  event.client = who;
  around_.tell(event, now);
}

}  // namespace cansyncd
