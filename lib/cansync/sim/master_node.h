#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "cansync/channel/jobs.h"
#include "cansync/master.h"
#include "cansync/settings/settings.h"
#include "sim/node.h"

// docs/simulated-drive.md describes the simulated master as a user sees it.
namespace sim {

/// How a reference value of the simulated master runs over the intervals. All of it is raw, as on the bus.
struct ReferenceCurve {
  /// What is released; `none`: the value is not released, nor its telegram when all of its values are none.
  enum class Kind : std::uint8_t {
    none,
    constant,  ///< `offset`
    ramp,      ///< `offset`, then `step` more with every interval, modulo 2^32
    sine,      ///< around `offset` with `amplitude` and `period`
  };
  Kind kind = Kind::none;
  std::int64_t offset = 0;
  std::int64_t step = 0;
  double amplitude = 0;
  std::uint32_t period = 1000;  ///< intervals of one turn, over 0
};

/// The value of a curve in interval `n`; 0 for one that is not released. Pure.
std::uint32_t value_of(const ReferenceCurve& curve, cansync::IntervalNumber n) noexcept;

/// One job that the simulated master submits by itself in active operation.
struct MasterRoutine {
  using Request = std::variant<cansync::ParameterRequest, cansync::TransferRequest,
                               cansync::ControlWordRequest, cansync::BroadcastRequest>;
  cansync::IntervalNumber from = 0;   ///< first interval
  cansync::IntervalNumber every = 0;  ///< again after so many intervals; 0: once
  Request request;                    ///< its id stands for every submission
};

/// Everything about a simulated master that can be set.
struct MasterNodeSettings {
  /// Bit rate, slaves that it expects, polling, activation; must have passed `cansync::check`.
  cansync::MasterSettings master;
  /// Time from joining the line to the first edge.
  can::Time first_edge{};
  /// Goes to set-up at the first edge, and to active operation as soon as the enable rule lets it.
  bool enable = true;
  std::array<ReferenceCurve, cansync::kValues> references = {};
  std::vector<MasterRoutine> routines;
  /// What the transfers of the routines move: their `data` points into these.
  std::vector<std::shared_ptr<std::vector<std::uint8_t>>> blocks;
};

/// A whole `cansync::Master` as a participant of a line, for slaves under test: it makes the SYNC edge and
/// sends every telegram at its planned start. Called late, as on a line that is not simulated, it leaves out
/// what would start after its slot, and an interval whose edge would be more than half of one late. Edges and
/// telegrams go missing by faults of the line (`missing_sync`; `lost` with the channel). Parameter jobs and
/// transfers are submitted to `master()` between two calls of the line, or by routines. Nothing allocates,
/// blocks or throws after construction; not thread safe.
class MasterNode final : public Node {
 public:
  /// `listener` must outlive the node. Null: nobody is told.
  explicit MasterNode(const MasterNodeSettings& settings, cansync::MasterListener* listener = nullptr);
  MasterNode(const MasterNode&) = delete;
  MasterNode& operator=(const MasterNode&) = delete;

  cansync::Master& master() noexcept { return master_; }
  const cansync::Master& master() const noexcept { return master_; }
  /// The interval that its last edge began, counted from 0; and when that edge was.
  cansync::IntervalNumber interval() const noexcept { return master_.interval(); }
  can::Time edge() const noexcept { return edge_; }
  /// Another curve from the next interval on; a value over 7 changes nothing.
  void set_reference(std::uint8_t value, const ReferenceCurve& curve) noexcept;
  /// Jobs of the routines that the master refused.
  std::uint64_t refused() const noexcept { return refused_; }

  // A master has no number; it is never asked for where that counts.
  NodeNumber node_number() const noexcept override { return 0; }
  bool is_master() const noexcept override { return true; }
  bool accepts(const can::Frame& frame) const noexcept override { return frame.is_standard_data(); }
  void on_sync(can::Time) noexcept override {}
  std::optional<Transmission> on_frame(const can::Frame& frame, can::Time end) noexcept override;
  std::optional<Transmission> on_join(can::Time now) noexcept override;
  std::optional<Transmission> on_sent(const can::Frame& frame, can::Time end) noexcept override;
  std::optional<can::Time> next_time() const noexcept override { return next_; }
  Deed on_time(can::Time now) noexcept override;

 private:
  struct PlannedSlot {
    can::Time at{};
    cansync::Slot slot = cansync::Slot::reference_one;
  };

  bool begin_interval(can::Time now) noexcept;
  void submit_references() noexcept;
  void submit_routines() noexcept;
  cansync::Refusal submit(const MasterRoutine::Request& request) noexcept;

  const MasterNodeSettings settings_;
  cansync::Duration interval_;
  cansync::Master master_;
  std::array<ReferenceCurve, cansync::kValues> references_;
  std::array<PlannedSlot, cansync::kSlots> slots_ = {};  ///< of the running interval, by time
  unsigned slot_ = cansync::kSlots;                      ///< the next of them
  cansync::IntervalNumber next_interval_ = 0;
  can::Time edge_{};
  can::Time planned_edge_{};  ///< of the running interval; `edge_` is when it was made
  can::Time next_{};
  std::uint64_t refused_ = 0;
};

}  // namespace sim
