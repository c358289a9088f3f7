#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "cansync/telegram/numbers.h"

/// Which value's low or high word stands in which word of a process data telegram (M 3.1.1.1, 3.2.2.4).
/// Pure functions; safe on the realtime thread.
namespace cansync {

inline constexpr unsigned kValues = 8;  ///< reference values, and actual values per slave
inline constexpr unsigned kWords = 4;   ///< words of one telegram

/// The eight 32-bit values of one direction.
using Values = std::array<std::uint32_t, kValues>;

/// What stands in one word of a telegram.
struct WordMapping {
  bool assigned = false;
  bool high = false;       ///< true: high word of the value
  std::uint8_t value = 0;  ///< value number 0..7
  friend constexpr bool operator==(const WordMapping&, const WordMapping&) = default;
};

/// One half of an actual value.
struct ActualWord {
  std::uint8_t value = 0;  ///< 0..7
  bool high = false;
  friend constexpr bool operator==(const ActualWord&, const ActualWord&) = default;
};

/// Mapping of one telegram: word 0 stands in bytes 0..1.
struct TelegramMapping {
  std::array<WordMapping, kWords> word = {};
  /// Number of words up to and including the last assigned one, 0..4.
  std::uint8_t used_words() const noexcept;
  /// Bit n: value n has at least one word here.
  std::uint8_t value_mask() const noexcept;
  /// Bit n: of value n the low word alone stands here, so it is a value of 16 bits.
  std::uint8_t word_mask() const noexcept;
  friend constexpr bool operator==(const TelegramMapping&, const TelegramMapping&) = default;
};

/// Both telegrams of one direction: index 0 is WRC1 or RDC1, index 1 is WRC2 or RDC2.
using ProcessMapping = std::array<TelegramMapping, kChannels>;

/// Register byte of a word (bit 0 assigned, 1 high word, 2..6 value number, 7 zero). Example: 0x0D is the low
/// word of value 3.
std::uint8_t to_register(const WordMapping& word) noexcept;

/// Word mapping from its register byte; nothing when bit 7 is set, the value number is over 7, or a word that
/// is not assigned names a value or the high word.
std::optional<WordMapping> from_register(std::uint8_t byte) noexcept;

/// Telegram mapping from the function blocks' array form: value numbers (-1 = unused) and high-word flags
/// (M 4.15). Nothing when a number is outside -1..7. The flag of an unused word does not count.
std::optional<TelegramMapping> from_arrays(std::span<const int, kWords> numbers,
                                           std::span<const bool, kWords> high) noexcept;

/// True when every value of the mapping belongs to its telegram: values 0..3 in the first, 4..7 in the
/// second.
bool values_fit(const TelegramMapping& mapping, Channel channel) noexcept;

/// Bit n: value n is carried as its low word alone, 16 bits; a value that is not mapped is none.
std::uint8_t word_mask(const ProcessMapping& mapping) noexcept;

/// True when the low word of `value` alone says it all: -32768..65535, as a word with or without a sign.
constexpr bool fits_word(std::uint32_t value) noexcept {
  return value <= 0xFFFFu || value >= 0xFFFF8000u;
}

/// The number that `raw` stands for. `word`: its low 16 bits alone count; `is_signed`: two's complement of
/// that width (word actual values, M 3.2.1.2).
constexpr std::int64_t number_of(std::uint32_t raw, bool word, bool is_signed) noexcept {
  if (word) {
    const auto bits = static_cast<std::uint16_t>(raw);
    return is_signed ? std::int64_t{static_cast<std::int16_t>(bits)} : std::int64_t{bits};
  }
  return is_signed ? std::int64_t{static_cast<std::int32_t>(raw)} : std::int64_t{raw};
}

/// Which word of the telegram carries this half, 0..3; nothing when none does.
std::optional<unsigned> position_of(const TelegramMapping& mapping, const ActualWord& half) noexcept;

/// The telegram words for `values`; words not assigned are 0.
std::array<std::uint16_t, kWords> pack(const TelegramMapping& mapping, const Values& values) noexcept;

/// Takes the first `words` telegram words into `values`. Of a value with one word in the telegram the other
/// becomes 0, whatever a mapping before this one brought; values without a word stay as they were.
void unpack(const TelegramMapping& mapping, std::span<const std::uint16_t> words, Values& values) noexcept;

/// A mapping worked out once for the many telegrams that come with it; does what `unpack` does.
class Unpacking {
 public:
  Unpacking() = default;  ///< of a mapping without words
  explicit Unpacking(const TelegramMapping& mapping) noexcept;
  /// Takes the first words of a telegram into `values`.
  void operator()(std::span<const std::uint16_t> words, Values& values) const noexcept;

 private:
  /// Where a value of a telegram that has all words comes from; a half that no word carries is masked out.
  struct Source {
    std::uint8_t value = 0;
    std::uint8_t low = 0;
    std::uint8_t high = 0;
    std::uint32_t carried = 0;
  };
  TelegramMapping mapping_;
  std::array<Source, kWords> sources_ = {};
  std::uint8_t values_ = 0;      ///< how many values have a source
  std::uint8_t used_words_ = 0;  ///< words of a telegram that has all of them
};

/// The mapping a line starts with: doubleword values 0 and 1 (4 and 5) of the telegram, low word first.
TelegramMapping default_mapping(Channel channel) noexcept;

}  // namespace cansync
