#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "can/frame.h"
#include "layer2/timers.h"

/// Event scripts (Helmholz 6.3.5): what a module does by itself when it is powered up, run and stopped.
///
///     // a line of comment
///     Send ID LENGTH BYTE...      a data frame
///     Fetch ID [LENGTH]           a remote frame
///     Start TIMER   Stop TIMER    1..16
///     Wait MILLISECONDS           1..65535
namespace layer2 {

/// What numbers of identifiers, lengths and data bytes without `0x` are. Timers and times are decimal.
enum class ScriptNumbers : std::uint8_t {
  marked,       ///< one digit, 0..9; more need 0x: 80 is refused
  decimal,      ///< 80 is eighty
  hexadecimal,  ///< 80 is 0x80
};

/// How a script is read.
struct ScriptRules {
  bool extended = false;  ///< identifiers have 29 bits; false: 11
  ScriptNumbers numbers = ScriptNumbers::marked;
};

/// One line of a script.
struct ScriptCommand {
  /// What is done; `send` also of a Fetch.
  enum class Kind : std::uint8_t { send, start, stop, wait };
  Kind kind = Kind::send;
  can::Frame frame;          ///< of `send`; a remote one is a Fetch
  std::uint16_t number = 0;  ///< timer 1..16, or time to wait, 1..65535 ms
  friend bool operator==(const ScriptCommand&, const ScriptCommand&) = default;
};

/// What is wrong with a script, and where.
struct ScriptProblem {
  std::size_t line = 1;    ///< from 1
  std::size_t column = 1;  ///< in bytes, from 1
  std::string text;        ///< what was found and what is allowed
};

/// A script as read.
struct Script {
  static constexpr std::size_t kMostLines = 100;  ///< with a command; comments and empty lines do not count
  std::vector<ScriptCommand> commands;            ///< only to be used when there are no problems
  std::vector<ScriptProblem> problems;            ///< in the order of the lines, one a line
};

/// Reads a script; lines end with a line feed. Never throws but for want of memory. Not for the realtime
/// thread.
Script parse_script(std::string_view text, const ScriptRules& rules = {});

/// Goes through a script, a command at a time. Realtime safe; one thread. It keeps no copy: a script that was
/// begun must outlive the runner or the next `begin`.
class ScriptRunner {
 public:
  /// Begins a script, in place of one that may be under way.
  void begin(const Script& script) noexcept;
  /// Breaks off.
  void end() noexcept { script_ = nullptr; }
  /// A script is under way.
  bool runs() const noexcept { return script_ != nullptr; }

  /// The next command when it may be done `now`; nothing: the script has ended, or waits. `wait` commands are
  /// the runner's own and never come. Say `done` when it was.
  std::optional<ScriptCommand> next(Time now) noexcept;
  /// What `next` said was done; the script goes on.
  void done() noexcept { ++at_; }
  /// When a wait is over; Time::max(): none is under way.
  Time next_deadline() const noexcept { return runs() ? until_ : Time::max(); }

 private:
  const Script* script_ = nullptr;
  std::size_t at_ = 0;
  Time until_ = Time::max();  ///< end of the wait under way
};

}  // namespace layer2
