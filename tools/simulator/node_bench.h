#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "sim/arbitration.h"
#include "sim/node.h"
#include "simulator/station.h"

namespace cansync_sim {

/// What a node bench has counted since its start.
struct NodeCounters {
  std::uint64_t received = 0;      ///< data and remote frames received
  std::uint64_t error_frames = 0;  ///< error frames received
  std::uint64_t sent = 0;          ///< frames sent
  std::uint64_t not_sent = 0;      ///< frames the interface did not take, or that had no room
};

/// A simulated node of any protocol without SYNC on a bus that is not simulated.
class NodeBench final : public Station {
 public:
  /// The node joins at `now`.
  NodeBench(std::unique_ptr<sim::Node> node, can::Time now);

  void receive(const can::ReceivedFrame& frame, can::Time now) noexcept override;
  can::Time next_due() const noexcept override;
  /// Of several frames the one with the lowest identifier comes first.
  std::optional<can::Frame> next(can::Time now) noexcept override;
  void sent(can::SendResult result) noexcept override;
  void link_lost() noexcept override;

  const NodeCounters& counters() const noexcept { return counters_; }

 private:
  /// Frames that wait at most.
  static constexpr std::size_t kMostWaiting = 256;

  void push(const std::optional<sim::Transmission>& transmission) noexcept;

  std::unique_ptr<sim::Node> node_;
  sim::PendingFrames waiting_{kMostWaiting};
  std::uint64_t order_ = 0;
  can::Frame last_;  ///< what `next` gave last
  can::Time last_taken_{};
  NodeCounters counters_;
};

/// What was received and sent, in one line.
std::string summary(const NodeBench& bench, std::uint64_t dropped);

}  // namespace cansync_sim
