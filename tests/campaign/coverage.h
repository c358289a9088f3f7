#pragma once

#include <array>
#include <cstdint>
#include <numeric>
#include <string>
#include <string_view>
#include <vector>

#include "cansync/channel/jobs.h"
#include "sim/faults.h"

namespace cansyncd::campaign {

/// What a campaign has met, and how often: a campaign that never meets a fault proves nothing about it.
class Coverage {
 public:
  enum class Met : std::uint8_t {
    bus_off,        ///< intervals that ended with the master in bus-off
    edges_skipped,  ///< SYNC edges
    ring_full,      ///< requests for which the ring had no room
    gateway_hung,   ///< intervals
    power_cycles,   ///< of drives
    stopped_early,  ///< schedules that end in the middle of everything
    left_active,    ///< intervals at whose end the master was not in active operation, having been in it
    uploads_done,
    downloads_done,
    writes_done,
    reads_done,
    changes_told,   ///< entries of the audit trail that were compared
    values_before,  ///< that name the value before
  };
  static constexpr std::size_t kMet = 13;

  void met(Met what, std::uint64_t times = 1) noexcept { met_[static_cast<std::size_t>(what)] += times; }
  void ended(cansync::Outcome outcome) noexcept { ++outcomes_[static_cast<std::size_t>(outcome)]; }
  void refused(cansync::Refusal refusal) noexcept { ++refusals_[static_cast<std::size_t>(refusal)]; }
  void hit(sim::FaultKind kind, std::uint64_t times) noexcept {
    faults_[static_cast<std::size_t>(kind)] += times;
  }

  void add(const Coverage& other) noexcept {
    const auto sum = [](auto& to, const auto& from) {
      for (std::size_t i = 0; i < to.size(); ++i) to[i] += from[i];
    };
    sum(met_, other.met_);
    sum(outcomes_, other.outcomes_);
    sum(refusals_, other.refusals_);
    sum(faults_, other.faults_);
  }

  /// Faults of every kind that hit.
  std::uint64_t hits() const noexcept {
    return std::accumulate(faults_.begin(), faults_.end(), std::uint64_t{0});
  }

  /// A line for each group.
  std::string text() const {
    std::string result = "faults hit:";
    for (std::size_t i = 0; i < faults_.size(); ++i) {
      result += item(name(static_cast<sim::FaultKind>(i)), faults_[i]);
    }
    result += "\njobs ended:";
    for (std::size_t i = 0; i < outcomes_.size(); ++i) {
      if (outcomes_[i] != 0) result += item(name(static_cast<cansync::Outcome>(i)), outcomes_[i]);
    }
    result += "\nrefused:";
    for (std::size_t i = 1; i < refusals_.size(); ++i) {
      if (refusals_[i] != 0) result += item(name(static_cast<cansync::Refusal>(i)), refusals_[i]);
    }
    result += "\nmet:";
    for (std::size_t i = 0; i < met_.size(); ++i) result += item(kNames[i], met_[i]);
    return result + "\n";
  }

  /// Names of what was never met and should have been.
  std::vector<std::string> missing() const {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < faults_.size(); ++i) {
      if (faults_[i] == 0) names.emplace_back(name(static_cast<sim::FaultKind>(i)));
    }
    for (const cansync::Outcome outcome : kWanted) {
      if (outcomes_[static_cast<std::size_t>(outcome)] == 0) names.emplace_back(name(outcome));
    }
    for (std::size_t i = 0; i < met_.size(); ++i) {
      if (met_[i] == 0) names.emplace_back(kNames[i]);
    }
    return names;
  }

 private:
  static constexpr std::array<std::string_view, kMet> kNames = {
      "bus_off",       "edges_skipped", "ring_full",    "gateway_hung",   "power_cycles",
      "stopped_early", "left_active",   "uploads_done", "downloads_done", "writes_done",
      "reads_done",    "changes_told",  "values_before"};
  static constexpr cansync::Outcome kWanted[] = {
      cansync::Outcome::done,      cansync::Outcome::slave_error,    cansync::Outcome::timeout,
      cansync::Outcome::no_answer, cansync::Outcome::word_expected,  cansync::Outcome::doubleword_expected,
      cansync::Outcome::cancelled, cansync::Outcome::value_too_wide, cansync::Outcome::master_stopped};
  static constexpr std::size_t kOutcomes = 64;
  static constexpr std::size_t kRefusals = 64;

  static std::string item(std::string_view what, std::uint64_t times) {
    return " " + std::string(what) + " " + std::to_string(times) + ",";
  }

  std::array<std::uint64_t, kMet> met_ = {};
  std::array<std::uint64_t, kOutcomes> outcomes_ = {};
  std::array<std::uint64_t, kRefusals> refusals_ = {};
  std::array<std::uint64_t, sim::kFaultKinds> faults_ = {};
};

}  // namespace cansyncd::campaign
