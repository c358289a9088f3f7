#pragma once

#include <fmt/format.h>

#include <array>
#include <bit>
#include <concepts>
#include <string>
#include <string_view>
#include <utility>

#include "cansync/dds/convert.h"
#include "daemon/cansync/status/metrics_families.h"

/// How the families of metrics_families.cpp are filled from the samples of the topics; only for that file.
namespace cansyncd::metrics {

/// A number of a sample, divided by `divisor` when its unit is another than the metric's.
template <std::int64_t divisor, class Number>
void add(MetricSamples& to, std::string_view labels, Number value) {
  if constexpr (divisor != 1) {
    to.add(labels, static_cast<double>(value) / static_cast<double>(divisor));
  } else if constexpr (std::signed_integral<Number>) {
    to.add(labels, std::int64_t{value});
  } else {
    to.add(labels, std::uint64_t{value});
  }
}

/// 1 for the word of `words` that is `current`, 0 for the others.
template <std::size_t count>
void add_states(MetricSamples& to, const std::string& labels,
                const std::array<std::string_view, count>& words, std::string_view current) {
  for (const std::string_view word : words) {
    to.add((labels.empty() ? "" : labels + ",") + label("state", word), std::uint64_t{word == current});
  }
}

// --- MasterStatus

template <auto member, std::int64_t divisor = 1>
void master_value(const MetricsSource& from, MetricSamples& to) {
  add<divisor>(to, {}, from.master.*member);
}

/// Slaves in a mask.
template <auto member>
void slaves_in(const MetricsSource& from, MetricSamples& to) {
  to.add({}, static_cast<std::uint64_t>(std::popcount(from.master.*member)));
}

/// One sample for each telegram of reference values.
template <auto member>
void release_value(const MetricsSource& from, MetricSamples& to) {
  for (unsigned i = 0; i < cansync::kChannels; ++i) {
    add<1>(to, label("telegram", fmt::format("{}", i + 1)), from.master.reference_release[i].*member);
  }
}

// --- SlaveStatus

inline std::string slave_labels(const cansync_SlaveStatus& slave) {
  return label("slave", fmt::format("{}", slave.slave)) + "," + label("name", gateway::dds::text(slave.name));
}

template <auto member, std::int64_t divisor = 1>
void slave_value(const MetricsSource& from, MetricSamples& to) {
  for (const cansync_SlaveStatus* slave : from.slaves) add<divisor>(to, slave_labels(*slave), slave->*member);
}

// --- Timing

/// The order of `cansync_Timing.slot`.
inline constexpr std::array<std::string_view, 6> kSlotNames = {"RC", "WRC1", "RDC1", "WRC2", "RDC2", "CC"};

template <auto member, std::int64_t divisor = 1>
void timing_value(const MetricsSource& from, MetricSamples& to) {
  if (from.timing != nullptr) add<divisor>(to, {}, from.timing->*member);
}

template <auto member, std::int64_t divisor = 1>
void slot_value(const MetricsSource& from, MetricSamples& to) {
  if (from.timing == nullptr) return;
  for (std::size_t i = 0; i < kSlotNames.size(); ++i) {
    add<divisor>(to, label("slot", kSlotNames[i]), from.timing->slot[i].*member);
  }
}

/// An instant in ns of telegrams that were seen; nothing for slots that had none.
template <auto member>
void slot_start(const MetricsSource& from, MetricSamples& to) {
  if (from.timing == nullptr) return;
  for (std::size_t i = 0; i < kSlotNames.size(); ++i) {
    const cansync_SlotTiming& slot = from.timing->slot[i];
    if (slot.count != 0) add<1'000'000'000>(to, label("slot", kSlotNames[i]), slot.*member);
  }
}

}  // namespace cansyncd::metrics
