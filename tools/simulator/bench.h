#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "can/bus.h"
#include "can/frame.h"
#include "cansync/settings/timing.h"
#include "cansync/sim/drive.h"
#include "cansync/telegram/numbers.h"
#include "sim/arbitration.h"
#include "sim/faults.h"
#include "simulator/station.h"

/// The drive simulator program `cansync-sim`: simulated drives on a CAN interface of the kernel.
namespace cansync_sim {

/// What a bench is, beside its drives.
struct BenchSettings {
  std::uint32_t sync_identifier = 0;                    ///< identifier of the software SYNC frame, 0..0x7FF
  cansync::BitRate bit_rate = cansync::BitRate::mbit1;  ///< fixes interval and slot times
  std::vector<sim::Fault> faults;                       ///< none of kind `corrupted`
  std::uint64_t seed = 1;                               ///< of the faults' chance
};

/// What a bench has counted since its start.
struct BenchCounters {
  std::uint64_t syncs = 0;          ///< SYNC frames received
  std::uint64_t received = 0;       ///< other data frames received
  std::uint64_t error_frames = 0;   ///< error frames received
  std::uint64_t sent = 0;           ///< frames sent, foreign ones of the fault script included
  std::uint64_t not_sent = 0;       ///< frames the interface did not take
  std::uint64_t too_late = 0;       ///< answers that would have come more than one interval late
  std::uint64_t faults_missed = 0;  ///< foreign frames of the fault script without room
};

/// Simulated drives on a bus that is not simulated. SYNC is a frame of its own (sync/software_sync.h), which
/// is no part of CANsync.
class Bench final : public Station {
 public:
  Bench(const BenchSettings& settings, std::vector<std::unique_ptr<sim::Drive>> drives);

  void receive(const can::ReceivedFrame& frame, can::Time now) noexcept override;
  can::Time next_due() const noexcept override;
  /// Of several frames the one with the lowest identifier comes first.
  std::optional<can::Frame> next(can::Time now) noexcept override;
  void sent(can::SendResult result) noexcept override;
  void link_lost() noexcept override;

  const BenchCounters& counters() const noexcept { return counters_; }
  const std::vector<std::unique_ptr<sim::Drive>>& drives() const noexcept { return drives_; }

 private:
  using DriveMask = std::uint32_t;  // bit n = drives_[n]
  static constexpr std::uint8_t kForeign = 0xFF;

  void sync(can::Time edge) noexcept;
  void deliver(const can::Frame& frame, can::Time end, can::Time now, DriveMask receivers) noexcept;
  void hand_over(std::uint8_t index, const sim::Transmission& answer, can::Time end, can::Time now) noexcept;
  bool push(const can::Frame& frame, can::Time ready, std::uint8_t sender, bool repeated) noexcept;
  DriveMask drives_of(sim::NodeSet numbers) const noexcept;
  DriveMask accepting(const can::Frame& frame) const noexcept;

  std::vector<std::unique_ptr<sim::Drive>> drives_;
  std::uint32_t sync_identifier_;
  std::uint32_t bits_per_second_;
  cansync::Duration interval_;  // answers older than that are not sent
  sim::FaultSchedule faults_;
  std::vector<DriveMask> acceptance_;  // by identifier
  sim::PendingFrames waiting_;
  DriveMask silent_ = 0;
  std::uint64_t order_ = 0;
  BenchCounters counters_;
};

}  // namespace cansync_sim
