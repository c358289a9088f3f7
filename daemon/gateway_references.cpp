#include "daemon/gateway_references.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "daemon/gateway_take.h"
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
      hold_(config.failsafe.reaction == LossReaction::hold ? config.failsafe.hold_intervals : 0) {}

bool ReferenceInput::take_samples(Exchange& exchange, SteadyTime now) {
  const bool more =
      take_with_info(reader_, [&](const cansync_ReferenceValues& sample, const dds_sample_info_t& info) {
        take(sample, info, exchange, now);
      });
  look_for_owners(now);
  return more;
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
  telegram.owner = info.publication_handle;
}

std::optional<std::string> ReferenceInput::problem(const cansync_ReferenceValues& sample,
                                                   const dds_sample_info_t& info) const {
  if (auto reason = dds::check(sample, limits_)) return reason;
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
  dds_subscription_matched_status_t status = {};
  if (dds_get_subscription_matched_status(reader_.handle(), &status) != DDS_RETCODE_OK) return;
  if (status.current_count == writers_ && status.total_count == writers_ever_) return;
  writers_ = status.current_count;
  writers_ever_ = status.total_count;
  for (unsigned channel = 0; channel < cansync::kChannels; ++channel) {
    if (telegrams_[channel].owner == 0) continue;
    dds_builtintopic_endpoint_t* const writer =
        dds_get_matched_publication_data(reader_.handle(), telegrams_[channel].owner);
    if (writer != nullptr) {
      dds_builtintopic_free_endpoint(writer);
    } else {
      // A weaker writer keeps the key alive, so DDS itself does not tell.
      writer_lost(channel, now);
    }
  }
}

void ReferenceInput::writer_lost(unsigned channel, SteadyTime now) {
  Telegram& telegram = telegrams_[channel];
  if (telegram.owner == 0) return;
  telegram.owner = 0;
  telegram.stop_wanted = true;
  events_.publish(
      {cansync_SEVERITY_WARNING, "reference_writer_lost", -1,
       fmt::format("the writer of the reference values of telegram {} has left or died; their release "
                   "is stopped{} until new ones come",
                   channel + 1, hold_ == 0 ? "" : fmt::format(" after at most {} intervals", hold_)),
       std::nullopt},
      now);
}

void ReferenceInput::push_stops(Exchange& exchange) {
  for (unsigned channel = 0; channel < cansync::kChannels; ++channel) {
    bool& wanted = telegrams_[channel].stop_wanted;
    if (wanted && exchange.requests.try_push(StopRelease{channel_of(channel), hold_})) wanted = false;
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
    if (const auto over = telegram.refused.next()) next = next ? std::min(*next, *over) : *over;
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
