#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "can/candump.h"
#include "cansync/telegram/telegram.h"
#include "cli/text/table.h"

/// Frames of a CANsync line in words.
namespace cansync::cli {

/// Identifier that stands for SYNC in the traces of the simulated line, and by default for the software SYNC.
inline constexpr std::uint32_t kSyncIdentifier = 0x080;

/// One frame in words.
struct TracedTelegram {
  std::chrono::microseconds time{};  ///< as in the log
  std::optional<std::chrono::microseconds>
      after_sync;                 ///< since the newest SYNC of the log; nothing before one
  std::string_view channel;       ///< SYNC, RC, WRC1, RDC1, WRC2, RDC2, CC, error, "-"
  std::optional<unsigned> slave;  ///< the slave that is addressed, asked or sends
  std::uint32_t slaves = 0;       ///< every slave it concerns: bit n = slave n
  std::string words;              ///< what it says
};

/// Puts frames into words. An answer's bytes mean what the command before it asked, so the newest command to
/// each slave is remembered; without one (the log begins later) the payload is told as it is.
class TraceText {
 public:
  /// `sync`: identifier of a frame that marks the SYNC edge, 0..0x7FF.
  explicit TraceText(std::uint32_t sync = kSyncIdentifier) : sync_(sync) {}

  /// Frames in the order of their time.
  TracedTelegram describe(const can::CandumpLine& line);

 private:
  void describe_command(const Telegram& telegram, TracedTelegram& out);
  void describe_answer(const Telegram& telegram, TracedTelegram& out) const;

  std::uint32_t sync_;
  std::optional<std::chrono::microseconds> edge_;
  std::array<std::optional<Telegram>, 32> asked_;  ///< newest command to each slave
};

/// One line for people: time in s, us after SYNC, channel, slave, words.
std::string trace_line(const TracedTelegram& telegram);

/// The columns of `trace_line`.
std::vector<Table::Column> trace_columns();
/// Their headings as a line.
std::string trace_heading();

}  // namespace cansync::cli
