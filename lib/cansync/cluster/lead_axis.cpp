#include "cansync/cluster/lead_axis.h"

namespace cansync {
namespace {

/// The longest data frame of 8 bytes with its stuff bits and the 3 bits after it.
constexpr int kLongestFrame = 135;

Channel channel_of_value(std::uint8_t value) noexcept {
  return value < kWords ? Channel::one : Channel::two;
}

/// Words that a telegram must have for this value to be whole; 0: it is not in it.
unsigned words_for(const TelegramMapping& mapping, std::uint8_t value) noexcept {
  unsigned words = 0;
  for (unsigned i = 0; i < kWords; ++i) {
    if (mapping.word[i].assigned && mapping.word[i].value == value) words = i + 1;
  }
  return words;
}

}  // namespace

unsigned lead_delay(const LeadSource& source, Channel lower, const SlotTimes& times, Duration send_margin,
                    Duration reserve) noexcept {
  if (source.kind == LeadSource::Kind::actual) return 0;
  const bool first = channel_of_value(source.value) == Channel::one;
  Duration start = first ? times.reference_one : times.reference_two;
  if (source.kind == LeadSource::Kind::monitored) start = first ? times.actual_one : times.actual_two;
  const Duration there = start + kLongestFrame * times.bit_time() + reserve;
  const Duration needed = (lower == Channel::one ? times.reference_one : times.reference_two) - send_margin;
  return there <= needed ? 0 : 1;
}

LeadAxis::LeadAxis(const LeadSources& sources, BitRate rate, Duration send_margin, Duration reserve) noexcept
    : sources_(sources), interval_(slot_times(rate).interval) {
  for (std::uint8_t value = 0; value < kValues; ++value) {
    if (sources[value].kind == LeadSource::Kind::none) continue;
    const Channel lower = channel_of_value(value);
    gives_[index(lower)] = static_cast<std::uint8_t>(gives_[index(lower)] | (1u << (value % kWords)));
    delay_[value] =
        static_cast<std::uint8_t>(lead_delay(sources[value], lower, slot_times(rate), send_margin, reserve));
  }
}

void LeadAxis::begin_interval(IntervalNumber now) noexcept {
  // Over intervals that were skipped everything is too old.
  if (now == now_ + 1) {
    previous_ = current_;
  } else {
    previous_ = {};
  }
  current_ = {};
  taken_ = {};
  now_ = now;
}

/// Null: too old for both.
LeadAxis::Samples* LeadAxis::samples_of(Duration since_sync) noexcept {
  if (since_sync >= Duration(0)) return &current_;
  return since_sync >= -interval_ ? &previous_ : nullptr;
}

void LeadAxis::keep(const LeadSource& source, unsigned words, const ProcessMapping& mapping,
                    const Values& values, Samples& samples) noexcept {
  const Channel channel = channel_of_value(source.value);
  const TelegramMapping& telegram = mapping[index(channel)];
  const unsigned needed = words_for(telegram, source.value);
  if (needed == 0 || words < needed) return;
  std::uint32_t value = values[source.value];
  const bool word = ((telegram.word_mask() >> source.value) & 1u) != 0;
  if (word) value = static_cast<std::uint32_t>(number_of(value, true, source.is_signed));
  for (unsigned lower = 0; lower < kValues; ++lower) {
    if (sources_[lower] == source) samples[lower] = {true, value};
  }
}

void LeadAxis::took_references(Channel channel, unsigned words, const ProcessMapping& mapping,
                               const Values& values, Duration since_sync) noexcept {
  Samples* const samples = samples_of(since_sync);
  if (samples == nullptr) return;
  for (const LeadSource& source : sources_) {
    if (source.kind == LeadSource::Kind::reference && channel_of_value(source.value) == channel)
      keep(source, words, mapping, values, *samples);
  }
}

void LeadAxis::took_monitored(SlaveNumber slave, Channel channel, unsigned words,
                              const ProcessMapping& mapping, const Values& values,
                              Duration since_sync) noexcept {
  Samples* const samples = samples_of(since_sync);
  if (samples == nullptr) return;
  for (const LeadSource& source : sources_) {
    const bool its = source.kind == LeadSource::Kind::monitored && source.slave == slave;
    if (its && channel_of_value(source.value) == channel) keep(source, words, mapping, values, *samples);
  }
}

void LeadAxis::released(Channel channel, std::uint8_t valid, const Values& values) noexcept {
  for (unsigned lower = 0; lower < kValues; ++lower) {
    const LeadSource& source = sources_[lower];
    if (source.kind != LeadSource::Kind::actual || channel_of_value(source.value) != channel) continue;
    if (((valid >> (source.value % kWords)) & 1u) != 0) current_[lower] = {true, values[source.value]};
  }
}

std::optional<ReferenceUpdate> LeadAxis::take(Channel channel) noexcept {
  const unsigned number = index(channel);
  if (gives_[number] == 0 || taken_[number]) return std::nullopt;
  taken_[number] = true;
  ReferenceUpdate update;
  update.channel = channel;
  update.from_interval = now_;
  for (unsigned i = 0; i < kWords; ++i) {
    if (((gives_[number] >> i) & 1u) == 0) continue;
    const unsigned value = number * kWords + i;
    const Sample& sample = delay_[value] == 0 ? current_[value] : previous_[value];
    if (!sample.there) {
      ++counters_[number].missing;
      return std::nullopt;
    }
    update.value[i] = sample.value;
  }
  update.valid_mask = gives_[number];
  ++counters_[number].given;
  return update;
}

}  // namespace cansync
