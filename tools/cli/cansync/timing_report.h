#pragma once

#include <cansync/client.h>
#include <cansync/topics.h>
#include <cansync/types.h>

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cli/text/table.h"
#include "text/json.h"

/// What the samples of the topic Timing say, for people and for programs. Pure functions.
namespace cansync::cli {

using text::JsonArray;
using text::JsonObject;

inline constexpr std::size_t kLatenessBuckets = 16;
inline constexpr std::size_t kSlotCount = 6;

/// When the telegrams of one slot were started, in ns after SYNC.
struct SlotReport {
  std::string_view name;     ///< RC, WRC1, RDC1, WRC2, RDC2, CC
  bool from_master = false;  ///< the master sends it; else a slave
  std::uint64_t count = 0;   ///< telegrams seen; 0: `earliest`, `mean` and `latest` mean nothing
  std::int64_t earliest = 0;
  std::int64_t mean = 0;
  std::int64_t latest = 0;
  std::optional<std::int64_t> planned;    ///< nothing for what the slaves send
  std::int64_t latest_start = 0;          ///< by the specification
  std::uint64_t late = 0;                 ///< started after that
  std::optional<std::uint64_t> left_out;  ///< nothing for what the slaves send
};

/// What a report says of the line.
struct LineFacts {
  std::string bus;
  std::uint32_t bit_rate = 0;         ///< bit/s
  std::uint64_t interval_length = 0;  ///< ns
};

/// As the daemon told them last. Throws client::NoDaemon.
LineFacts line_facts(const client::Client& client);

/// Lateness and slots of a span of time.
struct TimingReport {
  std::optional<std::uint32_t> seconds;  ///< counts are of these seconds; nothing: since the daemon's start
  std::uint64_t intervals = 0;
  std::int64_t lateness_minimum = 0;  ///< ns; of the seconds that were looked at
  std::int64_t lateness_mean = 0;
  std::int64_t lateness_maximum = 0;
  std::array<std::uint64_t, kLatenessBuckets> histogram = {};  ///< bucket n: under 2^n us; last: the rest
  std::array<SlotReport, kSlotCount> slots = {};
  std::uint64_t missed_syncs = 0;
  std::uint32_t bus_load = 0;  ///< permille
  std::string timestamp_source;
  std::string bus;
  std::uint32_t bit_rate = 0;         ///< bit/s
  std::uint64_t interval_length = 0;  ///< ns
};

/// The report of `samples` (at least one), in the order they came. With `before`, the sample that came before
/// them, counts are those of the samples' seconds; without, those since the daemon's start.
TimingReport timing_report(std::span<const client::Timing> samples, const client::Timing* before,
                           const LineFacts& line);

/// Upper bound in us of the bucket in which `percent` (0..100] of the counts lie; nothing when there are no
/// counts or it is the last bucket, which has no bound.
std::optional<std::uint64_t> percentile_us(const std::array<std::uint64_t, kLatenessBuckets>& histogram,
                                           double percent);

/// Bars of the wake-up lateness, in lines of at most `width` characters (at least 40 are used).
std::vector<std::string> histogram_lines(const TimingReport& report, std::size_t width);

/// One row for each slot.
Table slot_table(const TimingReport& report);

/// Its columns.
std::vector<Table::Column> slot_columns();

/// Everything for people, in lines; tables may be wider than `width`.
std::vector<std::string> report_lines(const TimingReport& report, std::size_t width);

/// Everything for programs; docs/command-line-json.md lists the keys.
JsonObject report_object(const TimingReport& report);

}  // namespace cansync::cli
