#pragma once

#include <cansync/topics.h>
#include <cansync/types.h>

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "cli/watch/watch_rows.h"

/// From samples of actual values to rows of a CSV file. No clocks, no files; one thread.
namespace cansync::cli {

/// Names of the columns before the values.
inline constexpr std::array<std::string_view, 6> kRecordColumns{"time",     "seconds", "receive_time_ns",
                                                                "interval", "slave",   "name"};

/// What is recorded of which slave, and where it stands.
class RecordPlan {
 public:
  /// A column for each name and unit that `slaves` have mapped; what has no name is "value3" by its number.
  /// `values`: those to take, by name or number (all when empty). Throws UsageError when no slave has one of
  /// them.
  RecordPlan(std::span<const client::SlaveStatus> slaves, const std::vector<std::string>& values, bool raw);

  /// Is what a slave told last what is recorded of it?
  bool knows(const client::SlaveStatus& slave) const;
  /// Takes up what a slave's values are from now on, recorded so far or not: the columns stay, and a value for which there
  /// is none is recorded no more. Returns what is different, a sentence each.
  std::vector<std::string> update(const client::SlaveStatus& slave);

  /// "position [mm]", in the order of the columns; "[raw]" for numbers as on the bus.
  const std::vector<std::string>& headings() const noexcept { return headings_; }
  bool raw() const noexcept { return raw_; }
  /// Where a slave's value 0..7 stands among the headings; nothing: it is not recorded.
  std::optional<std::size_t> column(unsigned slave, unsigned value) const;
  /// Whether the number of a value that is recorded has a sign.
  bool is_signed(unsigned slave, unsigned value) const { return values_.at(slave)[value]->is_signed; }
  const std::string& name(unsigned slave) const { return names_.at(slave); }
  bool records(unsigned slave) const { return names_.contains(slave); }
  std::vector<unsigned> slaves() const;
  /// The first line of the file, with its end.
  std::string header() const;

 private:
  /// What is told of a value that is wanted.
  struct Value {
    std::string heading;
    double factor = 1;  ///< of what is recorded: 1 and 0 for numbers as on the bus
    double offset = 0;
    bool is_signed = true;
    bool operator==(const Value&) const = default;
  };
  using Values = std::array<std::optional<Value>, kSlaveValues>;

  bool is_wanted(const client::SlaveStatus& slave, unsigned value) const;
  Values values_of(const client::SlaveStatus& slave) const;
  std::optional<std::size_t> column_of(const Value& value) const;
  std::string difference(const std::optional<Value>& before, const std::optional<Value>& now) const;

  std::vector<std::string> headings_;
  std::vector<std::string> wanted_;
  std::map<unsigned, Values> values_;
  std::map<unsigned, std::string> names_;
  bool raw_;
};

/// Which value every so often.
struct RecordCounts {
  std::uint64_t rows = 0;
  /// Turns of a slave without a row: it was not asked, did not answer, or the sample did not come through.
  std::uint64_t missing = 0;
};

/// Makes rows: what came of one slave in one interval, whichever telegrams brought it. What a sample repeats
/// from earlier telegrams is not written again. Rows come in the order of intervals.
class RecordRows {
 public:
  /// `every`: takes each Nth row of a slave; at least 1. `plan` must outlive this object.
  RecordRows(RecordPlan& plan, std::uint64_t every) : plan_(plan), every_(every) {}

  /// Who is asked how often, so that turns without a row are noticed; whenever it may have changed.
  void set_polling(const client::MasterStatus& status);
  /// The first sample of a slave tells what was before the recording; its values are not written.
  void take(const client::ActualValues& sample);
  /// The daemon was started anew; told at `now` (CLOCK_REALTIME, ns), before or after its first samples.
  /// Interval numbers begin again, and a comment says so: before the first sample with a lower number when
  /// one has come, else here. No turns are missing in between.
  void restarted(std::int64_t now);
  /// What a slave's values are has changed, or not; told at `now` (CLOCK_REALTIME, ns). What is different is returned, and
  /// stands as comments behind the rows of before.
  std::vector<std::string> update(const client::SlaveStatus& slave, std::int64_t now);
  /// The lines that are complete, each with its end: of intervals that were over at the call before, because
  /// DDS gives what waits slave by slave, and the half of it may be here. With `all`: those of the newest
  /// intervals too.
  std::string lines(bool all);
  const RecordCounts& counts() const noexcept { return counts_; }

 private:
  struct Row {
    std::int64_t time = 0;
    std::array<std::optional<double>, kSlaveValues> values = {};
  };
  struct Seen {
    std::array<std::uint64_t, 2> interval = {};
    std::optional<std::uint64_t> row;  ///< interval of the newest row
    std::uint64_t rows = 0;
  };
  using Place = std::pair<std::uint64_t, unsigned>;  // interval, slave

  void begin_again(std::int64_t now);
  bool of_new_start(const client::ActualValues& sample) const;
  std::string take_lines(bool all);
  void take_telegram(const client::ActualValues& sample, unsigned telegram);
  void count_missing(unsigned slave, Seen& seen, std::uint64_t interval);
  std::string line(const Place& place, const Row& row);

  RecordPlan& plan_;
  std::uint64_t every_;
  std::map<unsigned, Seen> seen_;
  std::map<Place, Row> open_;
  std::uint64_t newest_ = 0;
  std::uint64_t newest_before_ = 0;  ///< at the last call of `lines`
  std::array<std::int32_t, 2> polling_ = {};
  std::uint64_t round_ = 0;  ///< intervals of automatic polling until a slave's next turn
  std::optional<std::int64_t> first_time_;
  std::string before_;        ///< lines up to the newest start
  bool began_again_ = false;  ///< a sample told of the newest start, and nobody else has
  RecordCounts counts_;
};

/// An instant of CLOCK_REALTIME in ns as "2026-11-21T22:30:29.123456789Z".
std::string utc_text(std::int64_t nanoseconds);

}  // namespace cansync::cli
