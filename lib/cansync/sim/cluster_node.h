#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "cansync/cluster/cluster.h"
#include "cansync/slave/slave_service.h"
#include "cansync/slave/slave_supervision.h"
#include "sim/line.h"
#include "sim/node.h"
#include "sync/phase_lock.h"

namespace sim {

/// Everything about a simulated gateway between two lines that can be set.
struct ClusterNodeSettings {
  cansync::ClusterSettings cluster;
  cansync::SlaveServiceSettings service;  ///< of the gateway itself
  std::uint16_t status_parameter = 301;   ///< in the service's table
  cansync::Duration lock_time = std::chrono::milliseconds(20);
  can::Time delay{};  ///< from the end of a frame above until its answer is ready
  /// Most by which one interval of the lower bus differs from the nominal one.
  can::Time greatest_step = std::chrono::microseconds(1);
  can::Time holdover =
      std::chrono::milliseconds(100);  ///< edges missing above until the lower bus is stopped
  can::Time phase{};                   ///< of the timeline's first edge after that of the upper bus
};

/// A whole `cansync::Cluster`: a node of the upper line and the user, so the master, of the lower one. Its
/// timeline follows the upper line's edges by the daemon's phase lock, and makes the lower line's. The upper
/// line calls it as a node; `LevelRun` lets it act on the lower one. Not thread safe.
class ClusterNode final : public Node {
 public:
  /// `told` and `below` must outlive the node.
  ClusterNode(const ClusterNodeSettings& settings, cansync::SlaveServiceListener& told,
              cansync::MasterListener& below);
  ClusterNode(const ClusterNode&) = delete;
  ClusterNode& operator=(const ClusterNode&) = delete;

  /// The line whose master this is; before the first edge. It must outlive the node's last call.
  void connect(Line& lower) noexcept { lower_ = &lower; }

  /// Right after an interval has begun.
  std::function<void(ClusterNode&)> on_interval;
  /// By how much later than the settings say an answer is ready; empty: never later. What is ready after its
  /// slot never comes on the bus.
  std::function<can::Time()> slow;

  cansync::Cluster& cluster() noexcept { return cluster_; }
  cansync::SlaveService& service() noexcept { return service_; }
  cansync::SlaveSupervision& supervision() noexcept { return supervision_; }
  const sync_line::PhaseLock& lock() const noexcept { return lock_; }
  Line& lower() noexcept { return *lower_; }
  /// The timeline's newest edge, and its number.
  can::Time edge() const noexcept { return edge_; }
  cansync::IntervalNumber interval() const noexcept { return interval_; }

  /// When `act` is due; nothing before the first edge above.
  std::optional<can::Time> next_instant() const noexcept;
  /// What is due at `next_instant`: an edge of the timeline, or a slot of the lower bus. Both lines have come
  /// so far.
  void act() noexcept;
  /// Lets the lower line run until `to`, and gives its frames to the lower master.
  void advance_lower(can::Time to) noexcept;

  NodeNumber node_number() const noexcept override { return cluster_.upper().settings().number.value(); }
  bool accepts(const can::Frame& frame) const noexcept override;
  void on_sync(can::Time now) noexcept override;
  std::optional<Transmission> on_frame(const can::Frame& frame, can::Time end) noexcept override;
  std::optional<Transmission> on_sent(const can::Frame& frame, can::Time end) noexcept override;

 private:
  struct PlannedTelegram {
    can::Time at{};
    cansync::Slot slot = cansync::Slot::reference_one;
  };
  void begin_interval() noexcept;
  void send(cansync::Slot slot) noexcept;
  bool tracking() const noexcept;

  ClusterNodeSettings settings_;
  cansync::SlaveService service_;
  cansync::Cluster cluster_;
  cansync::SlaveSupervision supervision_;
  sync_line::PhaseLock lock_;
  Line* lower_ = nullptr;
  bool seen_ = false;
  can::Time newest_{};  ///< edge above
  can::Time edge_{};
  cansync::IntervalNumber interval_ = 0;
  std::array<PlannedTelegram, cansync::kSlots> slots_ = {};
  unsigned slot_ = cansync::kSlots;
};

/// Lines of several levels in one process and one virtual time: the upper line's master makes the edges, each
/// gateway acts on its lower line. The same lines, calls and seeds give the same course to the nanosecond.
class LevelRun {
 public:
  /// `top` is the line without a gateway above it; gateways from the highest level to the lowest, connected.
  LevelRun(Line& top, std::vector<ClusterNode*> gateways) : top_(top), gateways_(std::move(gateways)) {}
  /// Lets everything happen up to `until`.
  void run_to(can::Time until) noexcept;
  can::Time now() noexcept { return top_.now(); }

 private:
  Line& top_;
  std::vector<ClusterNode*> gateways_;
};

}  // namespace sim
