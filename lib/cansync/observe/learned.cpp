#include "cansync/observe/learned.h"

#include <algorithm>
#include <numeric>

namespace cansync::observe {
namespace {

constexpr Duration kTimeStampStep = std::chrono::microseconds(1);
/// More than the configuration takes.
constexpr Duration kGreatestMargin = std::chrono::microseconds(1000);

template <class T>
void found(Found<T>& out, T value, Certainty certainty, std::uint64_t count) {
  out = {value, count == 0 ? Certainty::not_seen : certainty, count};
}

void learn_timing(const Observation& observation, Learned& out) {
  const SlotTimes& times = slot_times(observation.bit_rate);
  const std::uint64_t votes = observation.interval_votes;
  found(out.interval, times.interval, observation.sync_seen ? Certainty::seen : Certainty::inferred, votes);
  // What was typed is known, whatever the interval says.
  const std::uint64_t typed = observation.bit_rate_given && observation.frames > 0 ? 1 : 0;
  found(out.bit_rate, observation.bit_rate, Certainty::inferred, std::max(votes, typed));
  if (!observation.sync_seen) return;
  // The bus may have been taken when a telegram was due, but none goes out before.
  const auto look = [&](Place place, Duration latest_start) {
    const SlotUse& use = observation.slot[static_cast<unsigned>(place)];
    if (use.count == 0) return;
    const Duration margin = std::clamp(latest_start - use.usual, Duration{0}, Duration{kGreatestMargin});
    const bool more = !out.send_margin.known() || margin > out.send_margin.value + kTimeStampStep;
    found(out.send_margin, more ? margin : out.send_margin.value, Certainty::inferred,
          out.send_margin.count + use.count);
  };
  look(Place::reference_one, times.reference_one);
  look(Place::reference_two, times.reference_two);
  look(Place::command, times.command);
  if (!out.send_margin.known()) look(Place::set_up_command, times.reference_one);
  // A greater one lets a telegram start before the slave's telegram in the slot before it: edges are missing in the
  // recording, or it is no master of these slots.
  const Duration greatest =
      std::min({times.reference_one - times.response, times.reference_two - times.actual_one,
                times.command - times.actual_two});
  if (out.send_margin.value > greatest) out.send_margin = {};
}

void learn_slaves(const Observation& observation, Learned& out) {
  for (unsigned i = 0; i < kSlaves; ++i) {
    const SlaveUse& use = observation.slave[i];
    const std::uint64_t heard = use.answers + use.stray + use.actual[0].count + use.actual[1].count;
    const SlaveNumber slave = *SlaveNumber::from(i);
    // A number that was asked once and never answered was looked for, and is not of the line.
    if (heard > 0 || use.commands > 1) out.slaves.value.set(slave);
    if (heard > 0) out.answered.value.set(slave);
    out.slaves.count += heard + use.commands;
    out.answered.count += heard;
  }
  found(out.slaves, out.slaves.value, Certainty::seen, out.slaves.count);
  found(out.answered, out.answered.value, Certainty::seen, out.answered.count);
}

Found<Cursor> polling_of(const PollingUse& use) {
  const auto of = [&use](unsigned from, unsigned to) {
    return std::accumulate(use.asked.begin() + from, use.asked.begin() + to, std::uint64_t{0});
  };
  const std::uint64_t slaves = of(0, kSlaves);
  const std::uint64_t nobody = of(kSlaves, 128);
  Found<Cursor> cursor;
  if (slaves == 0) {
    found(cursor, Cursor{Cursor::Kind::nobody, {}}, Certainty::seen, nobody);
    return cursor;
  }
  const auto most = std::max_element(use.asked.begin(), use.asked.begin() + kSlaves) - use.asked.begin();
  const auto number = *SlaveNumber::from(static_cast<unsigned>(most));
  const std::uint64_t most_count = use.asked[number.value()];
  if (most_count == slaves) {
    found(cursor, Cursor{Cursor::Kind::fixed, number},
          nobody == 0 && slaves > 1 ? Certainty::seen : Certainty::inferred, slaves);
    return cursor;
  }
  const std::uint64_t in_turn = use.rises + use.wraps;
  if (in_turn > use.stays)
    found(cursor, Cursor{}, use.stays + use.jumps + nobody == 0 ? Certainty::seen : Certainty::inferred,
          in_turn);
  else
    found(cursor, Cursor{Cursor::Kind::fixed, number}, Certainty::inferred, most_count);
  return cursor;
}

void learn_maximum(const Observation& observation, Learned& out) {
  for (unsigned c = 0; c < kChannels; ++c) {
    const PollingUse& use = observation.polling[c];
    if (!out.polling[c].known() || out.polling[c].value.kind != Cursor::Kind::automatic) continue;
    unsigned highest = 0;
    for (unsigned i = 0; i < kSlaves; ++i)
      if (use.asked[i] > 0) highest = i;
    const bool sure = use.wraps > 0 && use.wraps_from_least == use.wraps_from_most;
    if (out.maximum_slave.certainty == Certainty::seen && !sure) continue;
    found(out.maximum_slave, *SlaveNumber::from(sure ? use.wraps_from_most : highest),
          sure ? Certainty::seen : Certainty::inferred,
          out.maximum_slave.count + (sure ? use.wraps : use.asked[highest]));
  }
}

void learn_distance(const Observation& observation, Learned& out) {
  const bool both = out.polling[0].known() && out.polling[0].value.kind == Cursor::Kind::automatic &&
                    out.polling[1].known() && out.polling[1].value.kind == Cursor::Kind::automatic;
  const unsigned round = out.maximum_slave.value.value() + 1u;
  if (!both || round == 1) return;
  const auto& distance = observation.polling_distance;
  const std::uint64_t all = std::accumulate(distance.begin(), distance.end(), std::uint64_t{0});
  const unsigned ahead = (round + 1) / 2;
  const std::uint64_t apart = distance[ahead] + distance[(128 + ahead - round) & 0x7F];
  const bool is_apart = apart > distance[0];
  const std::uint64_t fits = is_apart ? apart : distance[0];
  found(out.polling_apart, is_apart, fits == all ? Certainty::seen : Certainty::inferred, fits);
}

/// Words as values: two neighbours that move as one doubleword, or do not speak against it, are one.
TelegramMapping mapping_of(const TelegramUse& use, unsigned words, unsigned first_value) {
  TelegramMapping mapping;
  unsigned value = first_value;
  for (unsigned i = 0; i < words;) {
    const PairUse& pair = use.pair[i / 2];
    const bool doubleword = i % 2 == 0 && i + 1 < words && pair.carries >= pair.breaks;
    const auto number = static_cast<std::uint8_t>(value++);
    mapping.word[i++] = {true, false, number};
    if (doubleword) mapping.word[i++] = {true, true, number};
  }
  return mapping;
}

void learn_ranges(const TelegramUse& use, const TelegramMapping& mapping, Learned& out) {
  for (unsigned i = 0; i < kWords; ++i) {
    const WordMapping& word = mapping.word[i];
    if (!word.assigned || word.high) continue;
    const bool doubleword = ((mapping.word_mask() >> word.value) & 1u) == 0;
    out.reference_range[word.value] = doubleword ? use.doubleword[i / 2] : use.word[i];
  }
}

unsigned most_words(const TelegramUse& use) {
  unsigned words = 0;
  for (unsigned i = 1; i < use.by_words.size(); ++i)
    if (use.by_words[i] > 0) words = i;
  return words;
}

void learn_words(const Observation& observation, Learned& out) {
  std::uint64_t full = 0;
  std::uint64_t shorter = 0;
  std::uint64_t empty = 0;
  for (unsigned c = 0; c < kChannels; ++c) {
    const TelegramUse& use = observation.reference[c];
    full += use.by_words[4];
    empty += use.by_words[0];
    shorter += use.by_words[1] + use.by_words[2] + use.by_words[3];
    const unsigned words = most_words(use);
    found(out.reference_mapping[c], mapping_of(use, words, c * kWords), Certainty::inferred,
          use.count - use.by_words[0]);
    learn_ranges(use, out.reference_mapping[c].value, out);
    for (unsigned i = 0; i < kSlaves; ++i) {
      const TelegramUse& actual = observation.slave[i].actual[c];
      found(out.slave[i].actual_mapping[c], mapping_of(actual, most_words(actual), c * kWords),
            Certainty::inferred, actual.count);
    }
  }
  if (shorter > 0)
    found(out.full_length, false, Certainty::seen, shorter);
  else
    found(out.full_length, true, Certainty::inferred, full);
  if (empty > 0)
    found(out.poll_without_reference, true, full + shorter > 0 ? Certainty::seen : Certainty::inferred,
          empty);
  else
    found(out.poll_without_reference, false, Certainty::inferred, observation.references_missing);
}

}  // namespace

void learn_process_data(const Observation& observation, Learned& out) {
  for (unsigned c = 0; c < kChannels; ++c) {
    const PollingUse& use = observation.polling[c];
    out.polling[c] = polling_of(use);
    // A slave that is polled alone belongs to the line, also when it never answered.
    const Found<Cursor>& polling = out.polling[c];
    if (polling.known() && polling.value.kind == Cursor::Kind::fixed)
      out.slaves.value.set(polling.value.slave);
    for (unsigned n = kSlaves; n < use.asked.size(); ++n)
      if (use.asked[n] > 0)
        found(out.poll_nobody, static_cast<std::uint8_t>(n), Certainty::seen,
              out.poll_nobody.count + use.asked[n]);
  }
  learn_maximum(observation, out);
  learn_distance(observation, out);
  learn_words(observation, out);
}

Learned learn(const Observation& observation) {
  Learned out;
  learn_timing(observation, out);
  learn_slaves(observation, out);
  learn_process_data(observation, out);
  learn_commands(observation, out);
  return out;
}

MasterSettings settings_of(const Learned& learned) {
  MasterSettings out;
  const auto take = [](auto& setting, const auto& point) {
    if (point.known()) setting = point.value;
  };
  take(out.bit_rate, learned.bit_rate);
  out.send_margin = default_send_margin(out.bit_rate);
  take(out.send_margin, learned.send_margin);
  ProcessSettings& process = out.process;
  take(process.maximum_slave, learned.maximum_slave);
  // Automatic cursors must reach every slave.
  for (const SlaveNumber slave : learned.slaves.value)
    if (slave.value() > process.maximum_slave.value()) process.maximum_slave = slave;
  take(process.polling_apart, learned.polling_apart);
  take(process.poll_nobody, learned.poll_nobody);
  take(process.full_length, learned.full_length);
  take(process.poll_without_reference, learned.poll_without_reference);
  if (learned.activation.known()) {
    out.startup.activate_command = learned.activation.value.command;
    out.startup.activate_data = learned.activation.value.data;
  }
  take(out.startup.status_period, learned.status_period);
  take(out.startup.enable, learned.enable);
  CommandChannelSettings& channel = out.command_channel;
  take(channel.serving, learned.serving);
  take(channel.address_step, learned.address_step);
  take(channel.cancel_at_start, learned.cancel_at_start);
  take(channel.repeat_unanswered_writes, learned.repeat_unanswered_writes);
  take(channel.allow_reserved_addresses, learned.allow_reserved_addresses);
  for (unsigned c = 0; c < kChannels; ++c) {
    take(process.polling[c], learned.polling[c]);
    take(process.reference_mapping[c], learned.reference_mapping[c]);
  }
  for (const SlaveNumber number : learned.slaves.value) {
    SlaveSettings& slave = out.slaves[number.value()];
    const LearnedSlave& of = learned.slave[number.value()];
    slave.configured = true;
    take(slave.status_parameter, of.status_parameter);
    take(slave.block_limit, of.block_limit);
    for (unsigned c = 0; c < kChannels; ++c) take(slave.actual_mapping[c], of.actual_mapping[c]);
  }
  return out;
}

}  // namespace cansync::observe
