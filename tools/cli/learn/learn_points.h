#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cansync/observe/learned.h"
#include "cli/text/table.h"

/// What was learned, point by point, in words. Pure, but for memory.
namespace cansync::cli {

/// One point: a setting by its name in the configuration, or a fact.
struct LearnedPoint {
  std::string name;   ///< "process.poll_nobody", "interval"
  std::string found;  ///< "127"; "-" when it is not seen
  observe::Certainty certainty = observe::Certainty::not_seen;
  std::uint64_t count = 0;   ///< telegrams, edges or jobs that tell it
  std::uint32_t slaves = 0;  ///< mask of those it holds for; 0: the whole line
};

/// All points, also those that the recording tells nothing of.
std::vector<LearnedPoint> learned_points(const observe::Observation& observation,
                                         const observe::Learned& learned);

/// "seen 12 times", "inferred", "not seen".
std::string certainty_text(observe::Certainty certainty, std::uint64_t count);
/// "seen", "inferred" or "not_seen", for programs.
std::string_view certainty_word(observe::Certainty certainty) noexcept;

/// "automatic", "nobody" or the slave's number, as the configuration has it.
std::string polled_text(const Cursor& cursor);
/// The value numbers of a mapping and their high-word flags, as the configuration has them: "[0, 0, 1, -1]".
std::string mapping_numbers(const TelegramMapping& mapping);
/// "[false, true, false, false]".
std::string mapping_flags(const TelegramMapping& mapping);
/// "all_synchronized" and so on, as the configuration has it.
std::string_view enable_text(EnableRule rule) noexcept;
/// Whole microseconds, rounded down.
std::int64_t microseconds_of(Duration time) noexcept;

/// The columns of the table of points.
std::vector<Table::Column> learned_columns();

}  // namespace cansync::cli
