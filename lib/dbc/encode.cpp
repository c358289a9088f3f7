#include "dbc/encode.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <limits>

namespace dbc {
namespace {

constexpr unsigned kByteBits = 8;
constexpr unsigned kMostBits = 64;

std::uint64_t ones(unsigned bits) noexcept {
  return bits >= kMostBits ? std::numeric_limits<std::uint64_t>::max() : (std::uint64_t{1} << bits) - 1;
}

/// Calls `use(byte, bit, place)` for each bit of the signal, `place` counted from its lowest.
template <class Use>
void for_each_bit(const Signal& signal, Use&& use) {
  std::size_t byte = signal.start / kByteBits;
  unsigned bit = signal.start % kByteBits;
  for (unsigned i = 0; i < signal.length; ++i) {
    if (signal.little_endian) {
      use(byte, bit, i);
      if (++bit == kByteBits) {
        bit = 0;
        ++byte;
      }
    } else {
      use(byte, bit, signal.length - 1 - i);
      if (bit-- == 0) {
        bit = kByteBits - 1;
        ++byte;
      }
    }
  }
}

/// Lowest and highest number of the bits, before factor and offset.
std::pair<double, double> numbers_of(const Signal& signal) noexcept {
  switch (signal.kind) {
    case NumberKind::unsigned_integer:
      return {0.0, static_cast<double>(ones(signal.length))};
    case NumberKind::signed_integer:
      return {-std::ldexp(1.0, static_cast<int>(signal.length) - 1),
              std::ldexp(1.0, static_cast<int>(signal.length) - 1) - 1};
    case NumberKind::float32:
      return {std::numeric_limits<float>::lowest(), std::numeric_limits<float>::max()};
    case NumberKind::text:
      return {0.0, 0.0};
    case NumberKind::float64:
      break;
  }
  return {std::numeric_limits<double>::lowest(), std::numeric_limits<double>::max()};
}

/// The bits of a whole number that fits.
std::uint64_t whole_bits(const Signal& signal, double number) noexcept {
  // What a double cannot tell from the number behind the largest one is the largest one.
  const unsigned bits = signal.kind == NumberKind::signed_integer ? signal.length - 1u : signal.length;
  if (number >= std::ldexp(1.0, static_cast<int>(bits))) return ones(bits);
  return number < 0 ? static_cast<std::uint64_t>(static_cast<std::int64_t>(number)) & ones(signal.length)
                    : static_cast<std::uint64_t>(number) & ones(signal.length);
}

/// A whole number whose value is its raw value.
bool is_plain_integer(const Signal& signal) noexcept {
  return signal.kind <= NumberKind::signed_integer && signal.factor == 1.0 && signal.offset == 0.0;
}

std::int64_t signed_of(const Signal& signal, std::uint64_t raw) noexcept {
  const unsigned unused = kMostBits - signal.length;
  return static_cast<std::int64_t>(raw << unused) >> unused;
}

}  // namespace

std::pair<double, double> range_of(const Signal& signal) noexcept {
  const auto [lowest, highest] = numbers_of(signal);
  const double one = lowest * signal.factor + signal.offset;
  const double other = highest * signal.factor + signal.offset;
  return std::minmax(one, other);
}

std::optional<std::uint64_t> raw_of(const Signal& signal, double value) noexcept {
  if (signal.kind == NumberKind::text) return std::nullopt;
  const double number = (value - signal.offset) / signal.factor;
  if (!std::isfinite(value) || !std::isfinite(number)) return std::nullopt;
  const auto [lowest, highest] = numbers_of(signal);
  if (signal.kind == NumberKind::float64) return std::bit_cast<std::uint64_t>(number);
  if (signal.kind == NumberKind::float32) {
    if (number < lowest || number > highest) return std::nullopt;
    return std::bit_cast<std::uint32_t>(static_cast<float>(number));
  }
  const double rounded = std::round(number);
  if (rounded < lowest || rounded > highest) return std::nullopt;
  return whole_bits(signal, rounded);
}

std::optional<std::uint64_t> raw_of_digits(const Signal& signal, std::string_view digits) noexcept {
  const auto whole_of = [digits](auto number) -> std::optional<decltype(number)> {
    const auto end = digits.data() + digits.size();
    const auto read = std::from_chars(digits.data(), end, number);
    return read.ec == std::errc() && read.ptr == end ? std::optional(number) : std::nullopt;
  };
  // A double cannot tell whole numbers of over 53 bits one from the other.
  if (is_plain_integer(signal)) {
    if (signal.kind == NumberKind::unsigned_integer) {
      if (const auto number = whole_of(std::uint64_t{0}))
        return *number <= ones(signal.length) ? number : std::nullopt;
    } else if (const auto number = whole_of(std::int64_t{0})) {
      const std::int64_t highest = static_cast<std::int64_t>(ones(signal.length) >> 1);
      if (*number > highest || *number < -highest - 1) return std::nullopt;
      return static_cast<std::uint64_t>(*number) & ones(signal.length);
    }
  }
  const auto number = whole_of(0.0);
  return number ? raw_of(signal, *number) : std::nullopt;
}

std::optional<std::uint64_t> raw_of(const Signal& signal, std::string_view word) noexcept {
  const auto found = std::find_if(signal.words.begin(), signal.words.end(),
                                  [word](const auto& one) { return one.second == word; });
  if (found == signal.words.end()) return std::nullopt;
  return raw_of_named(signal, found->first);
}

bool write_bits(const Signal& signal, std::uint64_t raw, std::span<std::uint8_t> data) noexcept {
  if (signal.kind == NumberKind::text || !lies_in(signal, data.size())) return false;
  for_each_bit(signal, [&](std::size_t byte, unsigned bit, unsigned place) {
    const auto one = static_cast<std::uint8_t>(1u << bit);
    const bool set = ((raw >> place) & 1) != 0;
    data[byte] = static_cast<std::uint8_t>(set ? data[byte] | one : data[byte] & ~one);
  });
  return true;
}

void choose(const Message& message, const Signal& signal, std::span<std::uint8_t> data) noexcept {
  for (const Signal* one = &signal; one->chosen_by;) {
    const Choice& choice = *one->chosen_by;
    one = &message.signals[choice.multiplexor];
    const auto raw = raw_bits(*one, data);
    const auto fits = [&raw](const auto& range) { return *raw >= range.first && *raw <= range.second; };
    if (raw && std::none_of(choice.ranges.begin(), choice.ranges.end(), fits))
      (void)write_bits(*one, choice.ranges.front().first, data);
  }
}

namespace {

bool is_close(std::string_view digits, double value, double distance) noexcept {
  double read = 0;
  std::from_chars(digits.data(), digits.data() + digits.size(), read);
  return std::abs(read - value) <= distance;
}

}  // namespace

std::string value_text(const Reading& reading) {
  const Signal& signal = *reading.signal;
  if (signal.kind == NumberKind::text) return reading.text;
  if (is_plain_integer(signal))
    return signal.kind == NumberKind::unsigned_integer ? fmt::format("{}", reading.raw)
                                                       : fmt::format("{}", signed_of(signal, reading.raw));
  constexpr int kMostDigits = 17;
  const bool whole = signal.kind <= NumberKind::signed_integer;
  const double step = std::abs(signal.factor) / 1000;  // an offset of half a step is not rounded away
  for (int digits = whole ? 10 : 6; digits < kMostDigits; ++digits) {
    std::string text = fmt::format("{:.{}g}", reading.value, digits);
    if (raw_of_digits(signal, text) == reading.raw && (!whole || is_close(text, reading.value, step)))
      return text;
  }
  return fmt::format("{:.{}g}", reading.value, kMostDigits);
}

}  // namespace dbc
