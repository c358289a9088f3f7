#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "cansync.h"
#include "daemon/cansync/exchange.h"
#include "daemon/status/common_status.h"

/// What the metrics file holds: one row a family. Pure functions; not for the realtime thread (allocates).
namespace cansyncd {

/// The samples that the topics had last, from which metrics are made.
struct MetricsSource {
  ToldCommon common;
  const cansync_MasterStatus& master;
  std::span<const cansync_SlaveStatus* const> slaves;  ///< of the configured slaves
  const cansync_Timing* timing = nullptr;              ///< null: none yet
  const TimingSnapshot& timing_snapshot;               ///< what `timing` was made of; for what is wider there
  std::uint64_t write_failures = 0;                    ///< times the metrics file could not be written
};

/// Takes the samples of one family as text.
class MetricSamples {
 public:
  /// `bus`: the label that every sample has.
  explicit MetricSamples(std::string_view bus);

  /// Begins a family. `name` with everything that belongs to it, e.g. "_total".
  void begin(std::string_view name) { name_ = name; }
  /// One sample; `labels`: those beside the bus, from `label`, separated by commas; may be empty.
  void add(std::string_view labels, std::uint64_t value, std::string_view suffix = {});
  void add(std::string_view labels, std::int64_t value, std::string_view suffix = {});
  void add(std::string_view labels, double value, std::string_view suffix = {});

  /// What was added, one line a sample.
  std::string take();

 private:
  void line(std::string_view labels, std::string_view suffix, std::string_view value);

  std::string bus_;
  std::string_view name_;
  std::string text_;
};

/// The order of `cansync_Timing.slot`.
inline constexpr std::array<std::string_view, 6> kSlotNames = {"RC", "WRC1", "RDC1", "WRC2", "RDC2", "CC"};

/// Labels of a slave's samples.
std::string slave_labels(const cansync_SlaveStatus& slave);

struct MetricFamily;

/// Adds the samples of a family that has no `fill` of its own, by the tables of the topics' members. Throws
/// std::logic_error for a source that no topic has.
void fill_from_member(const MetricFamily& family, const MetricsSource& from, MetricSamples& to);

/// NAME="VALUE" with the escapes of the format.
std::string label(std::string_view name, std::string_view value);

enum class MetricType : std::uint8_t { gauge, counter, histogram };
std::string_view name(MetricType type) noexcept;

/// One family of metrics.
struct MetricFamily {
  std::string_view name;  ///< without the "_total" of a counter's samples
  MetricType type;
  std::string_view labels;  ///< beside bus, for people
  /// Topic and member it is made of, e.g. "Timing.slot.count". With "..." at its end it is that member and
  /// all behind it whose names begin with the same word; `labels` names what the rest of their names says.
  std::string_view source;
  std::string_view help;
  void (*fill)(const MetricsSource&, MetricSamples&) = nullptr;  ///< null: the member as it is, in base units

  /// Base unit, the end of the name: seconds, ratio, bits_per_second; empty: a plain number.
  std::string_view unit() const noexcept;
};

/// Every family, in the order of the file.
std::span<const MetricFamily> metric_families() noexcept;

}  // namespace cansyncd
