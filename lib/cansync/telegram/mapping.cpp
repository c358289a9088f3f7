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
  unsigned high = 0;
  for (const WordMapping& entry : word) {
    if (entry.assigned && entry.high && entry.value < kValues) high |= 1u << entry.value;
  }
  return static_cast<std::uint8_t>(value_mask() & ~high);
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

void unpack(const TelegramMapping& mapping, std::span<const std::uint16_t> words, Values& values) noexcept {
  const std::size_t count = std::min<std::size_t>(words.size(), kWords);
  std::array<std::uint32_t, kValues> carried = {};
  for (const WordMapping& entry : mapping.word) {
    if (entry.assigned) carried[entry.value % kValues] |= entry.high ? 0xFFFF0000u : 0xFFFFu;
  }
  for (unsigned i = 0; i < kValues; ++i) {
    if (carried[i] != 0 && count != 0) values[i] &= carried[i];
  }
  for (std::size_t i = 0; i < count; ++i) {
    const WordMapping& entry = mapping.word[i];
    if (!entry.assigned) continue;
    std::uint32_t& value = values[entry.value % kValues];
    const unsigned shift = entry.high ? 16 : 0;
    value = (value & ~(0xFFFFu << shift)) | (static_cast<std::uint32_t>(words[i]) << shift);
  }
}

TelegramMapping default_mapping(Channel channel) noexcept {
  const std::uint8_t first = channel == Channel::one ? 0 : 4;
  const std::uint8_t second = channel == Channel::one ? 1 : 5;
  return {{{{true, false, first}, {true, true, first}, {true, false, second}, {true, true, second}}}};
}

}  // namespace cansync
