#include "cansync/process_data/process_data.h"

#include <algorithm>
#include <span>

namespace cansync {
namespace {

WordMasks word_masks(const ProcessMapping& mapping) noexcept {
  return {mapping[0].word_mask(), mapping[1].word_mask()};
}

std::array<CarriedValues, kChannels> carried_by(const ProcessMapping& mapping) noexcept {
  return {CarriedValues{mapping[0].value_mask(), mapping[0].word_mask()},
          CarriedValues{mapping[1].value_mask(), mapping[1].word_mask()}};
}

}  // namespace

ProcessData::ProcessData(const MasterSettings& settings, MasterListener& listener) noexcept
    : settings_(settings.process),
      listener_(listener),
      configured_(settings.configured()),
      carried_(carried_by(settings.process.reference_mapping)),
      check_(settings.process.reference_limits),
      output_{Output{ReferenceRelease(Channel::one, settings.process, listener), std::nullopt},
              Output{ReferenceRelease(Channel::two, settings.process, listener), std::nullopt}} {
  for (unsigned i = 0; i < kSlaves; ++i) set_mapping(i, settings.slaves[i].actual_mapping);
}

void ProcessData::set_mapping(unsigned slave, const ProcessMapping& mapping) noexcept {
  actual_mapping_[slave] = mapping;
  actual_words_[slave] = word_masks(mapping);
  actual_of_[slave] = {Unpacking(mapping[0]), Unpacking(mapping[1])};
  actual_by_mapping_[slave] = {};
}

void ProcessData::stop() noexcept {
  check_.forget();
  for (Output& output : output_) {
    output.release.stop();
    output.asked.reset();
  }
}

std::array<std::optional<SlaveNumber>, kChannels> ProcessData::begin_interval(IntervalNumber now) noexcept {
  now_ = now;
  std::array<std::optional<SlaveNumber>, kChannels> missed;
  for (unsigned i = 0; i < kChannels; ++i) {
    Output& output = output_[i];
    missed[i] = output.asked;
    output.asked.reset();
  }
  if (!first_) {
    const bool over = automatic_ >= settings_.maximum_slave.value();
    automatic_ = over ? std::uint8_t{0} : static_cast<std::uint8_t>(automatic_ + 1);
  }
  first_ = false;
  return missed;
}

Refusal ProcessData::update(const ReferenceUpdate& update) noexcept {
  // Whatever becomes of this update: the giver before gives no longer.
  if (update.takes_over) stop_release(update.channel, 0);
  if (update.mapping_number != mapping_number_) return Refusal::mapping_changed;
  if (update.valid_mask == 0 || update.valid_mask > 0x0F) return Refusal::nothing_valid;
  if (update.release_intervals == 0 || update.release_intervals > settings_.release_limit) {
    return Refusal::release_too_long;
  }
  if (!fits_words(update)) return Refusal::value_too_wide;
  const bool next = update.from_interval == 0;
  if (!next && (update.from_interval < now_ || update.from_interval > now_ + settings_.ahead_limit)) {
    return Refusal::interval_passed;
  }
  if (update.begins_before() != 0 && update.begins_before() <= now_) return Refusal::too_old;
  return output_[index(update.channel)].release.add(update) ? Refusal::none : Refusal::queue_full;
}

bool ProcessData::fits_words(const ReferenceUpdate& update) const noexcept {
  const unsigned first = index(update.channel) * 4;
  const unsigned words = carried_[index(update.channel)].words;
  for (unsigned v = 0; words != 0 && v < 4; ++v) {
    if (((words >> (first + v)) & 1u) == 0) continue;
    const bool is_new = ((update.valid_mask >> v) & 1u) != 0;
    // One that keeps its value may have got it under another mapping.
    if (!fits_word(is_new ? update.value[v] : references_[first + v])) return false;
  }
  return true;
}

void ProcessData::bus_lost() noexcept {
  for (const Channel channel : {Channel::one, Channel::two}) {
    output_[index(channel)].release.bus_lost();
    check_.withdrawn(channel);
  }
}

void ProcessData::stop_release(Channel channel, std::uint32_t hold) noexcept {
  output_[index(channel)].release.withdraw(hold);
  check_.withdrawn(channel);
}

std::uint8_t ProcessData::polled(Channel channel) const noexcept {
  const unsigned round = settings_.maximum_slave.value() + 1u;
  const unsigned ahead = channel == Channel::two && settings_.polling_apart ? (round + 1) / 2 : 0;
  const Cursor& cursor = settings_.polling[index(channel)];
  switch (cursor.kind) {
    case Cursor::Kind::automatic:
      return static_cast<std::uint8_t>(ahead == 0 ? automatic_ : (automatic_ + ahead) % round);
    case Cursor::Kind::fixed:
      return cursor.slave.value();
    case Cursor::Kind::nobody:
      break;
  }
  return settings_.poll_nobody;
}

void ProcessData::take_due(Channel channel) noexcept {
  ReferenceRelease& release = output_[index(channel)].release;
  const unsigned first_value = index(channel) * kWords;
  while (const auto update = release.next_due(now_)) {
    Values wanted = references_;
    for (unsigned v = 0; v < kWords; ++v) {
      if (((update->valid_mask >> v) & 1u) != 0) wanted[first_value + v] = update->value[v];
    }
    if (const auto beyond = check_.judge(channel, carried_[index(channel)], wanted, now_, *this)) {
      refuse(channel, *beyond);
      continue;
    }
    references_ = wanted;
    release.take(*update, now_);
    check_.taken(channel);
  }
}

void ProcessData::refuse(Channel channel, const LimitViolation& beyond) noexcept {
  output_[index(channel)].release.refuse();
  listener_.reference_beyond_limit(channel, beyond);
}

std::optional<ActualNumber> ProcessData::recent(SlaveNumber slave, std::uint8_t value) const noexcept {
  // Every slave is asked once in a round of the automatic number; what is two rounds old comes no more.
  const IntervalNumber limit = 2 * (settings_.maximum_slave.value() + IntervalNumber{1});
  const unsigned channel = value / kWords;
  const ActualValues& actual = actual_[slave.value()];
  const unsigned mapped = actual_mapping_[slave.value()][channel].value_mask();
  const bool came = actual_by_mapping_[slave.value()][channel] && ((mapped >> value) & 1u) != 0;
  if (!came || now_ - actual.interval[channel] > limit) return std::nullopt;
  return ActualNumber{actual.value[value], ((actual.words >> value) & 1u) != 0};
}

void ProcessData::set_reference_limits(std::uint8_t value, const ReferenceLimits& limits) noexcept {
  settings_.reference_limits[value] = limits;
  check_.set_limits(value, limits);
  const Channel channel = value < kWords ? Channel::one : Channel::two;
  if (output_[index(channel)].release.status().state == ReleaseStatus::State::stopped) return;
  const auto beyond = check_.judge_range(carried_[index(channel)], references_);
  if (!beyond) return;
  refuse(channel, *beyond);
  stop_release(channel, 0);
}

std::optional<ReferenceTelegram> ProcessData::telegram(Channel channel) noexcept {
  Output& output = output_[index(channel)];
  take_due(channel);
  ReferenceTelegram telegram;
  telegram.channel = channel;
  telegram.polled = polled(channel);
  output.released = output.release.decide(now_);
  if (!output.released) {
    ++not_released_;
    if (!settings_.poll_without_reference) return std::nullopt;
    telegram.words = 0;
    return telegram;
  }
  const TelegramMapping& mapping = settings_.reference_mapping[index(channel)];
  telegram.word = pack(mapping, references_);
  telegram.words = settings_.full_length ? kWords : mapping.used_words();
  return telegram;
}

void ProcessData::sent(Channel channel) noexcept {
  Output& output = output_[index(channel)];
  output.on_bus = false;
  if (output.released) check_.sent(carried_[index(channel)], references_, now_);
  output.release.sent();
  const auto slave = SlaveNumber::from(polled(channel));
  if (slave && configured_.has(*slave)) output.asked = slave;
}

void ProcessData::left_out(Channel channel) noexcept {
  output_[index(channel)].release.left_out();
}

bool ProcessData::receive(const ActualTelegram& telegram) noexcept {
  Output& output = output_[index(telegram.channel)];
  // What comes before the question was on the bus answers an earlier one, and is that old.
  if (output.asked != telegram.slave || !output.on_bus) return false;
  const unsigned channel = index(telegram.channel);
  const TelegramMapping& mapping = actual_mapping_[telegram.slave.value()][channel];
  // Else values that did not come would be told as new.
  if (telegram.words < mapping.used_words()) return false;
  output.asked.reset();
  ActualValues& actual = actual_[telegram.slave.value()];
  actual_of_[telegram.slave.value()][channel](std::span(telegram.word).first(telegram.words), actual.value);
  const unsigned others = telegram.channel == Channel::one ? 0xF0u : 0x0Fu;
  actual.words =
      static_cast<std::uint8_t>((actual.words & others) | actual_words_[telegram.slave.value()][channel]);
  actual.arrived = {};
  actual.arrived[channel] = true;
  actual_by_mapping_[telegram.slave.value()][channel] = true;
  actual.interval[channel] = now_;
  ++actual.count[channel];
  listener_.actual_values(telegram.slave, actual);
  return true;
}

namespace {

bool fits(const ProcessMapping& mapping) noexcept {
  return values_fit(mapping[0], Channel::one) && values_fit(mapping[1], Channel::two);
}

}  // namespace

Refusal ProcessData::set_reference_mapping(const ProcessMapping& mapping) noexcept {
  if (!fits(mapping)) return Refusal::mapping;
  if (mapping == settings_.reference_mapping) return Refusal::none;
  settings_.reference_mapping = mapping;
  carried_ = carried_by(mapping);
  ++mapping_number_;
  for (Output& output : output_) output.release.mapping_changed();
  return Refusal::none;
}

Refusal ProcessData::set_actual_mapping(SlaveNumber slave, const ProcessMapping& mapping) noexcept {
  if (!configured_.has(slave)) return Refusal::slave_not_configured;
  if (!fits(mapping)) return Refusal::mapping;
  set_mapping(slave.value(), mapping);
  return Refusal::none;
}

Refusal ProcessData::set_polling(Channel channel, const Cursor& cursor) noexcept {
  if (cursor.kind == Cursor::Kind::fixed && !configured_.has(cursor.slave))
    return Refusal::slave_not_configured;
  settings_.polling[index(channel)] = cursor;
  return Refusal::none;
}

}  // namespace cansync
