#include "dbc/database.h"

#include <algorithm>
#include <bit>
#include <tuple>

#include "dbc/foreign_text.h"

namespace dbc {
namespace {

constexpr unsigned kByteBits = 8;

/// `bits` lower bits of `raw` as two's complement.
std::int64_t sign_extended(std::uint64_t raw, unsigned bits) noexcept {
  const unsigned unused = (64 - bits) % 64;  // bits is 1..64
  return static_cast<std::int64_t>(raw << unused) >> unused;
}

double number_of(const Signal& signal, std::uint64_t raw) noexcept {
  switch (signal.kind) {
    case NumberKind::unsigned_integer:
      return static_cast<double>(raw);
    case NumberKind::signed_integer:
      return static_cast<double>(sign_extended(raw, signal.length));
    case NumberKind::float32:
      return static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(raw)));
    case NumberKind::float64:
      return std::bit_cast<double>(raw);
    case NumberKind::text:
      break;
  }
  return 0.0;
}

std::string_view word_of(const Signal& signal, std::uint64_t raw) noexcept {
  const auto found = std::find_if(signal.words.begin(), signal.words.end(),
                                  [&](const auto& word) { return raw_of_named(signal, word.first) == raw; });
  return found == signal.words.end() ? std::string_view() : std::string_view(found->second);
}

auto place_of(const Message& message) noexcept {
  return std::make_tuple(message.extended, message.identifier);
}

/// The characters of a text, as many as `data` has: a text is as long as it is, up to what the file says.
std::string characters_of(const Signal& signal, std::span<const std::uint8_t> data) {
  const auto behind = data.subspan(signal.start / kByteBits);
  const auto bytes = behind.first(std::min<std::size_t>(signal.length / kByteBits, behind.size()));
  const std::string_view all(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return as_utf8(all.substr(0, all.find('\0')));
}

}  // namespace

bool lies_in(const Signal& signal, std::size_t bytes) noexcept {
  // The last byte: a signal that begins at its highest bit goes on to lower bits and later bytes.
  const std::size_t bits = signal.length;
  const std::size_t first = signal.start / kByteBits;
  const std::size_t in_first =
      signal.little_endian ? kByteBits - signal.start % kByteBits : signal.start % kByteBits + 1;
  const std::size_t more = bits > in_first ? (bits - in_first + kByteBits - 1) / kByteBits : 0;
  return first + more < bytes;
}

std::optional<std::uint64_t> raw_of_named(const Signal& signal, std::int64_t number) noexcept {
  constexpr unsigned kMostBits = 64;
  switch (signal.kind) {
    case NumberKind::text:
      return std::nullopt;
    case NumberKind::float32:
      return std::bit_cast<std::uint32_t>(static_cast<float>(number));
    case NumberKind::float64:
      return std::bit_cast<std::uint64_t>(static_cast<double>(number));
    case NumberKind::unsigned_integer:
    case NumberKind::signed_integer:
      break;
  }
  const auto bits = static_cast<std::uint64_t>(number);
  if (signal.length >= kMostBits) return bits;
  const std::int64_t numbers = std::int64_t{1} << (signal.length - 1);  // half of those that it has
  if (number < -numbers || number > 2 * (numbers - 1) + 1) return std::nullopt;
  return bits & ((std::uint64_t{1} << signal.length) - 1);
}

std::optional<std::uint64_t> raw_bits(const Signal& signal, std::span<const std::uint8_t> data) noexcept {
  std::uint64_t raw = 0;
  std::size_t byte = signal.start / kByteBits;
  unsigned bit = signal.start % kByteBits;
  for (unsigned i = 0; i < signal.length; ++i) {
    if (byte >= data.size()) return std::nullopt;
    const std::uint64_t one = (data[byte] >> bit) & 1U;
    if (signal.little_endian) {
      raw |= one << i;
      if (++bit == kByteBits) {
        bit = 0;
        ++byte;
      }
    } else {
      raw = (raw << 1U) | one;
      if (bit-- == 0) {
        bit = kByteBits - 1;
        ++byte;
      }
    }
  }
  return raw;
}

bool is_chosen(const Message& message, const Signal& signal, std::span<const std::uint8_t> data) noexcept {
  for (const Signal* one = &signal; one->chosen_by;) {
    const Choice& choice = *one->chosen_by;
    one = &message.signals[choice.multiplexor];
    const auto raw = raw_bits(*one, data);
    const auto fits = [&raw](const auto& range) { return *raw >= range.first && *raw <= range.second; };
    if (!raw || std::none_of(choice.ranges.begin(), choice.ranges.end(), fits)) return false;
  }
  return true;
}

std::vector<Reading> read_signals(const Message& message, std::span<const std::uint8_t> data) {
  std::vector<Reading> readings;
  for (const Signal& signal : message.signals) {
    if (!is_chosen(message, signal, data)) continue;
    if (signal.kind == NumberKind::text) {
      if (signal.start / kByteBits < data.size())
        readings.push_back({&signal, 0, 0.0, {}, characters_of(signal, data)});
      continue;
    }
    if (!lies_in(signal, data.size())) continue;
    const auto raw = raw_bits(signal, data);
    if (!raw) continue;
    readings.push_back(
        {&signal, *raw, number_of(signal, *raw) * signal.factor + signal.offset, word_of(signal, *raw), {}});
  }
  return readings;
}

Database::Database(std::vector<Message> messages) : messages_(std::move(messages)) {
  std::sort(messages_.begin(), messages_.end(),
            [](const Message& one, const Message& other) { return place_of(one) < place_of(other); });
}

const Message* Database::find(std::uint32_t identifier, bool extended) const noexcept {
  const auto wanted = std::make_tuple(extended, identifier);
  const auto found =
      std::lower_bound(messages_.begin(), messages_.end(), wanted,
                       [](const Message& message, const auto& place) { return place_of(message) < place; });
  return found != messages_.end() && place_of(*found) == wanted ? &*found : nullptr;
}

}  // namespace dbc
