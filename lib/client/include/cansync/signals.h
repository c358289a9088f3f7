#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "export.h"

namespace cansync::client {

/// A file of signals cannot be read, or a message cannot be made: what() says what, where, and what is
/// allowed.
class CANSYNC_PUBLIC SignalError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A signal of a message that came.
struct SignalValue {
  std::string name;
  double value = 0.0;     ///< in `unit`; not a number: `word` says why there is none
  std::string unit;       ///< may be empty
  std::uint64_t raw = 0;  ///< its bits
  std::string
      word;  ///< the name of this value; empty: it has none. Of a signal of over 64 bits its text; `raw` is 0
};

/// What bytes are.
struct NamedMessage {
  std::string name;
  std::vector<SignalValue> signals;  ///< those that are there, in the order of the file
};

/// A frame that was made. Of a group of J1939 the identifier has the file's priority and source.
struct EncodedMessage {
  std::uint32_t identifier = 0;
  bool extended = false;  ///< it has 29 bits
  std::vector<std::uint8_t> data;
};

/// Messages and signals by name, of a DBC file or a table in TOML (docs/signals.md). Does not change; any
/// thread.
class CANSYNC_PUBLIC Signals {
 public:
  /// A number in the signal's unit, or the name of a value.
  using Setting = std::variant<double, std::string>;

  /// Reads a table when the file's name ends in .toml, else a DBC file, of up to 16 MiB. Throws SignalError
  /// with what is wrong when the file has no message that can be used. See `remarks`.
  static Signals read(const std::string& path);

  /// What was left out of the file, or taken otherwise than it is written: "FILE:LINE:COLUMN: what and why";
  /// the first 10000. Empty: the file was read completely.
  const std::vector<std::string>& remarks() const noexcept;

  /// What a frame is; nothing: the file has no message of this identifier. `data` may be shorter than it
  /// says.
  std::optional<NamedMessage> decode(std::uint32_t identifier, bool extended,
                                     std::span<const std::uint8_t> data) const;
  /// What a message of J1939 is, whatever priority the file gives its group. Of several messages of the group that
  /// for this destination counts, of these that of this source; 254 and 255 in the file stand for any. What is no
  /// value has the word "not available", "error", "reserved" or "parameter specific" (SAE J1939-71).
  std::optional<NamedMessage> decode_group(std::uint32_t pgn, std::uint8_t source, std::uint8_t destination,
                                           std::span<const std::uint8_t> data) const;
  /// Likewise of a message to all.
  std::optional<NamedMessage> decode_group(std::uint32_t pgn, std::uint8_t source,
                                           std::span<const std::uint8_t> data) const;

  /// Makes a message of signals by name; bits that none gives are those of `rest`, 0xFF for J1939. Throws
  /// SignalError when a name is unknown, a value is out of what its bits can be or the file allows, or signals
  /// exclude each other.
  EncodedMessage encode(const std::string& message, const std::map<std::string, Setting>& signals,
                        std::uint8_t rest = 0) const;

 private:
  struct Names;
  explicit Signals(std::shared_ptr<const Names> names) noexcept;

  std::shared_ptr<const Names> names_;
};

}  // namespace cansync::client
