#include "daemon/cansync/gateway/gateway_references.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "daemon/desk/access.h"
#include "dds/convert.h"

namespace cansyncd {
namespace {

namespace dds = cansync::dds;

cansync::Channel channel_of(unsigned index) noexcept {
  return index == 0 ? cansync::Channel::one : cansync::Channel::two;
}

}  // namespace

ReferenceInput::ReferenceInput(const dds::Participant& participant, dds::DataSignal& signal,
                               EventPublisher& events, const Config& config)
    : reader_(participant, &signal),
      events_(events),
      limits_(dds::limits_of(config.master)),
      maximum_age_(config.failsafe.reference_max_age),
      hold_(config.failsafe.reaction == LossReaction::hold ? config.failsafe.hold_intervals : 0),
      deadline_(config.failsafe.reference_deadline),
      writers_(participant, reader_.handle()),
      refusal_(read_only_refusal_of_references(config)) {}

void ReferenceInput::watch(const std::array<cansync::ReleaseStatus, cansync::kChannels>& release) {
  for (unsigned channel = 0; channel < cansync::kChannels; ++channel) {
    Telegram& telegram = telegrams_[channel];
    if (release[channel].too_old == telegram.too_old) continue;
    telegram.too_old = release[channel].too_old;
    lose(channel, Loss::too_old);  // the realtime thread has told and stopped it already
  }
}

bool ReferenceInput::take_reaction(unsigned channel) noexcept {
  return std::exchange(telegrams_[channel].reaction_due, false);
}

void ReferenceInput::set_refusal(std::optional<std::string> reason) {
  if (reason && !refusal_) {
    for (Telegram& telegram : telegrams_) telegram.stop_wanted = true;
  }
  refusal_ = std::move(reason);
}

bool ReferenceInput::take_samples(Exchange& exchange, SteadyTime now) {
  const auto count =
      reader_.take_batch([&](const cansync_ReferenceValues& sample, const dds_sample_info_t& info) {
        take(sample, info, exchange, now);
      });
  look_for_owners(now);
  return count == dds::ReaderBase::kBatch;
}

void ReferenceInput::take(const cansync_ReferenceValues& sample, const dds_sample_info_t& info,
                          Exchange& exchange, SteadyTime now) {
  const bool known_telegram = sample.telegram == 1 || sample.telegram == 2;
  // A key that is no telegram still needs a place to be counted.
  const unsigned channel = sample.telegram == 2 ? 1 : 0;
  if (info.instance_state != DDS_IST_ALIVE) {
    // Also with data: values whose writer has gone meanwhile are not released any more.
    if (known_telegram) writer_lost(channel, now);
    return;
  }
  if (!info.valid_data) return;
  if (auto reason = problem(sample, info)) {
    count_refused(channel, std::move(*reason), std::nullopt, now);
    return;
  }
  push_stops(exchange);
  Telegram& telegram = telegrams_[channel];
  cansync::ReferenceUpdate update = dds::to_core(sample);
  update.takes_over = telegram.owner != 0 && telegram.owner != info.publication_handle;
  if (telegram.stop_wanted || !exchange.requests.try_push(update)) {
    count_refused(
        channel,
        fmt::format("request queue full: {} requests wait for the realtime thread, at most {} are allowed",
                    exchange.requests.size(), exchange.requests.capacity()),
        std::nullopt, now);
    return;
  }
  telegram.newest = update;
  accepted(channel, info.publication_handle, now);
}

void ReferenceInput::accepted(unsigned channel, dds_instance_handle_t writer, SteadyTime now) {
  Telegram& telegram = telegrams_[channel];
  if (telegram.owner != writer) announce(channel, writer, now);
  telegram.owner = writer;
  telegram.given = now;
  telegram.deadline_missed = false;
  telegram.reacted = false;
  givers_[channel].loss = Loss::none;
}

void ReferenceInput::announce(unsigned channel, dds_instance_handle_t writer, SteadyTime now) {
  const dds::WriterIdentity identity = writers_.identify(writer);
  ReferenceGiver& giver = givers_[channel];
  const dds_instance_handle_t before = telegrams_[channel].owner;
  if (before != 0) {
    events_.publish(
        {cansync_SEVERITY_WARNING, "reference_writer_taken_over", -1,
         fmt::format("{} (strength {}) has taken over the reference values of telegram {} from {} (strength "
                     "{}){}",
                     identity.who, identity.strength, channel + 1, giver.who, giver.strength,
                     writers_.left(before) ? ", which has left" : ""),
         std::nullopt, std::nullopt, identity.who},
        now);
  } else {
    events_.publish({cansync_SEVERITY_INFO, "reference_writer_began", -1,
                     fmt::format("{} (strength {}) gives the reference values of telegram {}", identity.who,
                                 identity.strength, channel + 1),
                     std::nullopt, std::nullopt, identity.who},
                    now);
  }
  giver.who = identity.who;
  giver.strength = identity.strength;
}

std::optional<std::string> ReferenceInput::problem(const cansync_ReferenceValues& sample,
                                                   const dds_sample_info_t& info) const {
  if (auto reason = dds::check(sample, limits_)) return reason;
  if (refusal_) return refusal_;
  if (maximum_age_.count() == 0) return std::nullopt;
  const std::int64_t age = (wall_clock_now() - info.source_timestamp) / 1'000'000;
  if (age < -maximum_age_.count()) {
    return fmt::format(
        "written {} ms in the future: at most {} ms are allowed (failsafe.reference_max_age_ms); set the "
        "clocks of both computers",
        -age, maximum_age_.count());
  }
  if (age <= maximum_age_.count()) return std::nullopt;
  return fmt::format(
      "age {} ms: at most {} ms are allowed (failsafe.reference_max_age_ms); write fresh values, and "
      "set the clocks of both computers",
      age, maximum_age_.count());
}

void ReferenceInput::look_for_owners(SteadyTime now) {
  if (!writers_.look()) return;
  for (unsigned channel = 0; channel < cansync::kChannels; ++channel) {
    const dds_instance_handle_t owner = telegrams_[channel].owner;
    if (owner != 0 && writers_.gone(owner)) writer_lost(channel, now);
  }
}

void ReferenceInput::writer_lost(unsigned channel, SteadyTime now) {
  Telegram& telegram = telegrams_[channel];
  if (telegram.owner == 0) return;
  telegram.owner = 0;
  telegram.stop_wanted = true;
  events_.publish({cansync_SEVERITY_WARNING, "reference_writer_lost", -1,
                   fmt::format("{}, which gave the reference values of telegram {}, has left or died; {}",
                               givers_[channel].who, channel + 1, reaction_text()),
                   std::nullopt, std::nullopt, givers_[channel].who},
                  now);
  givers_[channel] = {};
  lose(channel, Loss::writer_lost);
}

void ReferenceInput::lose(unsigned channel, Loss loss) {
  Telegram& telegram = telegrams_[channel];
  givers_[channel].loss = loss;
  telegram.reaction_due = telegram.reaction_due || !telegram.reacted;
  telegram.reacted = true;
}

std::string ReferenceInput::reaction_text() const {
  if (hold_ == 0) return "their release is stopped until new ones come";
  return fmt::format("their release is stopped after at most {} intervals until new ones come", hold_);
}

std::optional<SteadyTime> ReferenceInput::look_at_deadline(unsigned channel, SteadyTime now) {
  Telegram& telegram = telegrams_[channel];
  if (deadline_.count() == 0 || telegram.owner == 0) return std::nullopt;
  if (telegram.deadline_missed) return std::nullopt;
  if (now < telegram.given + deadline_) return telegram.given + deadline_;
  telegram.deadline_missed = true;
  telegram.stop_wanted = true;
  events_.publish({cansync_SEVERITY_WARNING, "reference_deadline_missed", -1,
                   fmt::format("{} lives, but has given no new reference values of telegram {} for {} ms "
                               "(failsafe.reference_deadline_ms); {}",
                               givers_[channel].who, channel + 1, deadline_.count(), reaction_text()),
                   std::nullopt, std::nullopt, givers_[channel].who},
                  now);
  lose(channel, Loss::deadline_missed);
  return std::nullopt;
}

void ReferenceInput::push_stops(Exchange& exchange) {
  for (unsigned channel = 0; channel < cansync::kChannels; ++channel) {
    bool& wanted = telegrams_[channel].stop_wanted;
    if (wanted && exchange.requests.try_push(StopRelease{channel_of(channel), refusal_ ? 0 : hold_}))
      wanted = false;
  }
}

void ReferenceInput::refused(const ReferenceRefused& report, const Config& config,
                             const RefusalContext& context, SteadyTime now) {
  const unsigned channel = cansync::index(report.channel);
  count_refused(channel, refusal_text(report.refusal, telegrams_[channel].newest, config, context),
                report.when, now);
}

void ReferenceInput::count_refused(unsigned channel, std::string reason, std::optional<Moment> when,
                                   SteadyTime now) {
  Telegram& telegram = telegrams_[channel];
  if (!telegram.refused.add(1, now)) return;
  telegram.reason = std::move(reason);
  events_.publish(
      {cansync_SEVERITY_WARNING, "reference_refused", -1,
       fmt::format("reference values of telegram {} are refused: {}", channel + 1, telegram.reason), when},
      now);
}

std::optional<SteadyTime> ReferenceInput::tick(SteadyTime now) {
  std::optional<SteadyTime> next;
  for (unsigned channel = 0; channel < cansync::kChannels; ++channel) {
    Telegram& telegram = telegrams_[channel];
    const std::uint64_t refused = telegram.refused.take_over(now);
    for (const auto due : {telegram.refused.next(), look_at_deadline(channel, now)}) {
      if (due) next = next ? std::min(*next, *due) : *due;
    }
    if (refused == 0) continue;
    events_.publish(
        {cansync_SEVERITY_INFO, "reference_refusals_over", -1,
         fmt::format(
             "no reference values of telegram {} were refused for {} s; {} were before, the first because "
             "of {}",
             channel + 1, kQuiet.count(), refused, telegram.reason),
         std::nullopt},
        now);
  }
  return next;
}

}  // namespace cansyncd
