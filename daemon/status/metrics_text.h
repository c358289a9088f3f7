#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "text/members.h"

/// The metrics file of any protocol: families, one row each, and the samples of topics that they are made of.
/// Pure functions; not for the realtime thread (allocates).
namespace cansyncd {

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

/// A struct of a sample, and the labels of its numbers.
struct LabelledSample {
  const void* sample = nullptr;
  std::string labels;
};

/// The samples that a topic had last.
struct MetricTopic {
  std::string_view name;
  std::span<const text::Member> members;
  std::vector<LabelledSample> samples;  ///< none: nothing was told yet
};

/// A topic with one sample.
template <class T>
MetricTopic metric_topic(std::string_view name, const T& sample) {
  return {name, text::members_of<T>, {{&sample, {}}}};
}

/// The elements of arrays that are told apart by this label.
struct ElementNames {
  std::string_view label;
  std::span<const std::string_view> names;
};

/// What metrics are made of; a protocol's own has it as its base.
struct MetricsSource {
  std::string_view bus;
  std::vector<MetricTopic> topics;
  std::span<const ElementNames> element_names;  ///< of arrays; others have numbers from 1 on
  std::uint64_t write_failures = 0;             ///< times the metrics file could not be written
};

/// Throws std::logic_error for a topic that the source has not.
const MetricTopic& topic_of(std::string_view name, const MetricsSource& from);

/// The sample of a topic that has one.
template <class T>
const T& sample_of(std::string_view topic, const MetricsSource& from) {
  return *static_cast<const T*>(topic_of(topic, from).samples.front().sample);
}

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

/// Families that are written one after the other.
using MetricFamilies = std::span<const MetricFamily>;

/// Adds the samples of a family that has no `fill` of its own, by the tables of the topics' members. Throws
/// std::logic_error for a source that no topic has.
void fill_from_member(const MetricFamily& family, const MetricsSource& from, MetricSamples& to);

/// NAME="VALUE" with the escapes of the format.
std::string label(std::string_view name, std::string_view value);

/// 1 for the word of `words` that is `current`, 0 for the others; `labels` beside "state" may be empty.
template <std::size_t count>
void add_states(MetricSamples& to, const std::string& labels,
                const std::array<std::string_view, count>& words, std::string_view current) {
  for (const std::string_view word : words)
    to.add((labels.empty() ? "" : labels + ",") + label("state", word), std::uint64_t{word == current});
}

/// The whole metrics file: OpenMetrics text that parsers of the older Prometheus text format read too.
std::string metrics_text(const MetricsSource& from, std::initializer_list<MetricFamilies> families);

}  // namespace cansyncd
