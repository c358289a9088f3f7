#include "cansync/observe/process_watch.h"

#include <algorithm>

#include "cansync/telegram/mapping.h"

namespace cansync::observe {
namespace {

/// A value of 32 bits that moves on by less than half its low word each time looks like one.
bool moves_steadily(std::uint16_t low, std::uint16_t high, std::uint16_t low_before,
                    std::uint16_t high_before) noexcept {
  const auto now = static_cast<std::uint32_t>(low | (high << 16));
  const auto before = static_cast<std::uint32_t>(low_before | (high_before << 16));
  const auto step = static_cast<std::int32_t>(now - before);
  return step > -0x8000 && step < 0x8000;
}

}  // namespace

void NumberRange::add(std::int64_t number) noexcept {
  if (count++ == 0) {
    least = greatest = number;
  } else {
    least = std::min(least, number);
    greatest = std::max(greatest, number);
    step = std::max(step, number > newest ? number - newest : newest - number);
  }
  newest = number;
}

void ProcessWatch::look(TelegramUse& use, Last& last, std::uint8_t words,
                        const std::array<std::uint16_t, 4>& word) noexcept {
  ++use.count;
  ++use.by_words[std::min<std::size_t>(words, 4)];
  for (unsigned i = 0; i < words && i < 4; ++i) {
    const auto bit = static_cast<std::uint8_t>(1u << i);
    use.word[i].add(number_of(word[i], true, true));
    if (i % 2 == 1) use.doubleword[i / 2].add(static_cast<std::int32_t>(word[i - 1] | (word[i] << 16)));
    if (word[i] != 0) use.not_zero = static_cast<std::uint8_t>(use.not_zero | bit);
    if (last.word && i < last.words && (*last.word)[i] != word[i])
      use.moved = static_cast<std::uint8_t>(use.moved | bit);
  }
  for (unsigned p = 0; p < 2 && last.word; ++p) {
    const unsigned low = 2 * p;
    if (words < low + 2 || last.words < low + 2 || word[low + 1] == (*last.word)[low + 1]) continue;
    const bool steady = moves_steadily(word[low], word[low + 1], (*last.word)[low], (*last.word)[low + 1]);
    ++(steady ? use.pair[p].carries : use.pair[p].breaks);
  }
  if (words == 0) return;
  last = {word, words};
}

void ProcessWatch::reference(const ReferenceTelegram& telegram, Instant at) noexcept {
  const unsigned channel = index(telegram.channel);
  look(out_.reference[channel], last_reference_[channel], telegram.words, telegram.word);
  PollingUse& polling = out_.polling[channel];
  Asked& asked = asked_[channel];
  const std::uint8_t number = telegram.polled & 0x7F;
  ++polling.asked[number];
  if (asked.number) {
    if (*asked.number < kSlaves && !asked.came) ++out_.slave[*asked.number].missed_actual[channel];
    const IntervalNumber apart = at.interval - asked.interval;
    if (apart == 1) {
      if (number == *asked.number) {
        ++polling.stays;
      } else if (number == *asked.number + 1) {
        ++polling.rises;
      } else if (number == 0) {
        ++polling.wraps;
        polling.wraps_from_least = std::min(polling.wraps_from_least, *asked.number);
        polling.wraps_from_most = std::max(polling.wraps_from_most, *asked.number);
      } else {
        ++polling.jumps;
      }
    } else if (telegram.channel == Channel::one && apart > 1 && apart < 1000) {
      out_.references_missing += apart - 1;
    }
  }
  asked = {number, false, at.interval};
  const Asked& first = asked_[0];
  if (telegram.channel == Channel::two && first.number && first.interval == at.interval)
    ++out_.polling_distance[static_cast<std::uint8_t>(number - *first.number) & 0x7F];
}

void ProcessWatch::actual(const ActualTelegram& telegram) noexcept {
  const unsigned channel = index(telegram.channel);
  const unsigned slave = telegram.slave.value();
  look(out_.slave[slave].actual[channel], last_actual_[slave][channel], telegram.words, telegram.word);
  Asked& asked = asked_[channel];
  if (asked.number == slave) asked.came = true;
}

}  // namespace cansync::observe
