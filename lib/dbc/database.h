#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "can/frame.h"

/// Messages and signals by name, as a DBC file describes them. Plain values; they allocate, so not for the
/// realtime thread.
namespace dbc {

/// How the bits of a signal are a number; `text`: whole bytes, which are characters.
enum class NumberKind : std::uint8_t { unsigned_integer, signed_integer, float32, float64, text };

/// Which raw values of another signal of the message a signal is there with.
struct Choice {
  std::size_t multiplexor = 0;                                  ///< in Message::signals
  std::vector<std::pair<std::uint64_t, std::uint64_t>> ranges;  ///< lowest and highest raw value of each
};

/// A part of a message.
struct Signal {
  std::string name;
  std::string unit;  ///< UTF-8; may be empty
  unsigned start =
      0;  ///< bit in the file's own count: bit 0 is the lowest of byte 0, bit 8 the lowest of byte 1
  unsigned length = 1;  ///< bits, 1..64; of a text 8..14280, whole bytes
  bool little_endian =
      true;  ///< `start` is the lowest bit; false: the highest, and it goes on to lower bits and later bytes
  NumberKind kind = NumberKind::unsigned_integer;
  double factor = 1.0;  ///< value = raw * factor + offset
  double offset = 0.0;  ///< in `unit`
  std::optional<std::pair<double, double>>
      limits;                       ///< lowest and highest value that the file allows, in `unit`
  bool chooses = false;             ///< its raw value says which of the others are there (multiplexor)
  std::optional<Choice> chosen_by;  ///< nothing: it is there always. No chain of choices returns to its begin
  std::vector<std::pair<std::int64_t, std::string>> words;  ///< raw values that have a name
};

/// A message that one identifier carries.
struct Message {
  std::uint32_t identifier = 0;  ///< 0..0x7FF; extended 0..0x1FFFFFFF
  bool extended = false;         ///< the identifier has 29 bits
  unsigned length = 0;           ///< bytes, 0..1785
  std::string name;
  std::vector<Signal> signals;  ///< in the order of the file
};

/// The value of a signal in a message that came.
struct Reading {
  const Signal* signal = nullptr;  ///< lives as long as its message
  std::uint64_t raw = 0;           ///< its bits; 0 of a text
  double value = 0.0;     ///< in the signal's unit; 0 of a text; not a number: `word` says why there is none
  std::string_view word;  ///< the name of this raw value; empty: it has none
  std::string text;       ///< of a text: its bytes before the first 0 or the end of the data, UTF-8
};

/// Do all bits of the signal lie in a message of so many bytes?
bool lies_in(const Signal& signal, std::size_t bytes) noexcept;

/// The bits that a file means with the number of a named value (Signal::words), which may be signed or not whatever the
/// signal is; nothing when its bits cannot be that.
std::optional<std::uint64_t> raw_of_named(const Signal& signal, std::int64_t number) noexcept;

/// The bits of a signal that is no text in `data`, which may be shorter than its message; nothing when not all
/// of them are there.
std::optional<std::uint64_t> raw_bits(const Signal& signal, std::span<const std::uint8_t> data) noexcept;

/// The signals that are in `data`, in the order of the file: those whose bits are all there, of texts the first byte, and
/// that their multiplexors, if they have any, choose.
std::vector<Reading> read_signals(const Message& message, std::span<const std::uint8_t> data);

/// Do the multiplexors of the signal, in these data, choose it?
bool is_chosen(const Message& message, const Signal& signal, std::span<const std::uint8_t> data) noexcept;

/// The messages of a file.
class Database {
 public:
  /// Takes messages of which no two have the same identifier and width.
  explicit Database(std::vector<Message> messages);
  Database() = default;

  /// The message of a frame's identifier; null: there is none.
  const Message* find(std::uint32_t identifier, bool extended) const noexcept;
  const Message* find(const can::Frame& frame) const noexcept { return find(frame.id, frame.extended); }

  /// By rising identifier, those of 11 bits first.
  const std::vector<Message>& messages() const noexcept { return messages_; }

 private:
  std::vector<Message> messages_;
};

}  // namespace dbc
