#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "cansync/sim/master_node.h"
#include "simulator/station.h"

namespace cansync_sim {

/// What a simulated master has counted since its start, beside the counters of `cansync::Master`.
struct MasterBenchCounters {
  std::uint64_t syncs = 0;         ///< SYNC frames handed to the interface
  std::uint64_t received = 0;      ///< data frames received
  std::uint64_t error_frames = 0;  ///< error frames received
  std::uint64_t sent = 0;          ///< telegrams the interface took
  std::uint64_t not_sent = 0;      ///< frames the interface did not take, SYNC frames included
};

/// A simulated master on a bus that is not simulated. SYNC is a frame of its own (sync/software_sync.h),
/// which is no part of CANsync. A telegram whose latest start has passed is left out. `next` may tell news.
class MasterBench final : public Station {
 public:
  /// `tell` takes one line about the state of the line or of a slave, without line feed; may be empty.
  MasterBench(const sim::MasterNodeSettings& settings, std::uint32_t sync_identifier,
              std::function<void(const std::string&)> tell);
  ~MasterBench() override;

  void receive(const can::ReceivedFrame& frame, can::Time now) noexcept override;
  can::Time next_due() const noexcept override;
  /// The SYNC frame comes before the telegrams of its interval.
  std::optional<can::Frame> next(can::Time now) noexcept override;
  void sent(can::SendResult result) noexcept override;
  void link_lost() noexcept override {}

  const MasterBenchCounters& counters() const noexcept { return counters_; }
  const cansync::Master& master() const noexcept { return node_.master(); }

 private:
  class News;

  std::unique_ptr<News> news_;
  sim::MasterNode node_;
  std::uint32_t sync_identifier_;
  bool joined_ = false;
  can::Frame given_;  // by `next`, last
  can::Time given_at_{};
  MasterBenchCounters counters_;
};

/// What was done, in one line.
std::string summary(const MasterBench& bench, std::uint64_t dropped);

}  // namespace cansync_sim
