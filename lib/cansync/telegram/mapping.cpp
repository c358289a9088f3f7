#include "cansync/telegram/mapping.h"

#include <algorithm>

namespace cansync {
namespace {

// Bits of a register byte (M 3.1.1.1).
constexpr unsigned kAssigned = 0x01;
constexpr unsigned kHigh = 0x02;
constexpr unsigned kValueShift = 2;
constexpr unsigned kValueMask = 0x1F;
constexpr unsigned kReserved = 0x80;

/// Bit n: the low, or the high word of value n has a place in the telegram.
struct Carried {
  unsigned low = 0;
  unsigned high = 0;
};

Carried carried_by(const TelegramMapping& mapping) noexcept {
  Carried carried;
  for (const WordMapping& entry : mapping.word) {
    if (entry.assigned) (entry.high ? carried.high : carried.low) |= 1u << (entry.value % kValues);
  }
  return carried;
}

}  // namespace

std::uint8_t TelegramMapping::used_words() const noexcept {
  for (unsigned i = kWords; i > 0; --i) {
    if (word[i - 1].assigned) return static_cast<std::uint8_t>(i);
  }
  return 0;
}

std::uint8_t TelegramMapping::value_mask() const noexcept {
  unsigned mask = 0;
  for (const WordMapping& entry : word) {
    if (entry.assigned && entry.value < kValues) mask |= 1u << entry.value;
  }
  return static_cast<std::uint8_t>(mask);
}

std::uint8_t TelegramMapping::word_mask() const noexcept {
  const Carried carried = carried_by(*this);
  return static_cast<std::uint8_t>(carried.low & ~carried.high);
}

std::optional<unsigned> position_of(const TelegramMapping& mapping, const ActualWord& half) noexcept {
  for (unsigned i = 0; i < kWords; ++i) {
    if (mapping.word[i] == WordMapping{true, half.high, half.value}) return i;
  }
  return std::nullopt;
}

std::uint8_t word_mask(const ProcessMapping& mapping) noexcept {
  return static_cast<std::uint8_t>(mapping[0].word_mask() | mapping[1].word_mask());
}

std::uint8_t to_register(const WordMapping& word) noexcept {
  if (!word.assigned) return 0;
  return static_cast<std::uint8_t>(kAssigned | (word.high ? kHigh : 0u) |
                                   ((word.value & kValueMask) << kValueShift));
}

std::optional<WordMapping> from_register(std::uint8_t byte) noexcept {
  if ((byte & kAssigned) == 0) {
    if (byte != 0) return std::nullopt;
    return WordMapping{};
  }
  const unsigned value = (byte >> kValueShift) & kValueMask;
  if ((byte & kReserved) != 0 || value >= kValues) return std::nullopt;
  return WordMapping{true, (byte & kHigh) != 0, static_cast<std::uint8_t>(value)};
}

std::optional<TelegramMapping> from_arrays(std::span<const int, kWords> numbers,
                                           std::span<const bool, kWords> high) noexcept {
  TelegramMapping mapping;
  for (unsigned i = 0; i < kWords; ++i) {
    if (numbers[i] == -1) continue;
    if (numbers[i] < 0 || numbers[i] >= static_cast<int>(kValues)) return std::nullopt;
    mapping.word[i] = {true, high[i], static_cast<std::uint8_t>(numbers[i])};
  }
  return mapping;
}

bool values_fit(const TelegramMapping& mapping, Channel channel) noexcept {
  const unsigned first = channel == Channel::one ? 0 : 4;
  return std::all_of(mapping.word.begin(), mapping.word.end(), [first](const WordMapping& entry) {
    return !entry.assigned || (entry.value >= first && entry.value < first + 4);
  });
}

std::array<std::uint16_t, kWords> pack(const TelegramMapping& mapping, const Values& values) noexcept {
  std::array<std::uint16_t, kWords> words = {};
  for (unsigned i = 0; i < kWords; ++i) {
    const WordMapping& entry = mapping.word[i];
    if (!entry.assigned || entry.value >= kValues) continue;
    words[i] = static_cast<std::uint16_t>(values[entry.value] >> (entry.high ? 16 : 0));
  }
  return words;
}

Unpacking::Unpacking(const TelegramMapping& mapping) noexcept
    : mapping_(mapping), used_words_(mapping.used_words()) {
  for (unsigned i = 0; i < kWords; ++i) {
    const WordMapping& entry = mapping.word[i];
    if (!entry.assigned) continue;
    const auto number = static_cast<std::uint8_t>(entry.value % kValues);
    const auto end = sources_.begin() + values_;
    const auto source =
        std::find_if(sources_.begin(), end, [number](const Source& known) { return known.value == number; });
    if (source == end) ++values_;
    source->value = number;
    (entry.high ? source->high : source->low) = static_cast<std::uint8_t>(i);
    source->carried |= entry.high ? 0xFFFF0000u : 0xFFFFu;
  }
}

void Unpacking::operator()(std::span<const std::uint16_t> words, Values& values) const noexcept {
  if (words.empty()) return;
  if (words.size() >= used_words_) {  // the usual telegram; every drive of a simulated line takes each
    for (unsigned i = 0; i < values_; ++i) {
      const Source& source = sources_[i];
      const std::uint32_t high = words[source.high];
      values[source.value] = (words[source.low] | high << 16) & source.carried;
    }
    return;
  }
  for (unsigned i = 0; i < words.size(); ++i) {
    const WordMapping& entry = mapping_.word[i];
    if (!entry.assigned) continue;
    std::uint32_t& value = values[entry.value % kValues];
    const std::uint32_t word = words[i];
    value = entry.high ? (value & 0xFFFFu) | word << 16 : (value & 0xFFFF0000u) | word;
  }
  for (unsigned i = 0; i < values_; ++i) values[sources_[i].value] &= sources_[i].carried;
}

void unpack(const TelegramMapping& mapping, std::span<const std::uint16_t> words, Values& values) noexcept {
  Unpacking{mapping}(words, values);
}

TelegramMapping default_mapping(Channel channel) noexcept {
  const std::uint8_t first = channel == Channel::one ? 0 : 4;
  const std::uint8_t second = channel == Channel::one ? 1 : 5;
  return {{{{true, false, first}, {true, true, first}, {true, false, second}, {true, true, second}}}};
}

}  // namespace cansync
