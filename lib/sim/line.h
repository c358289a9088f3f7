#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "can/bus.h"
#include "can/frame.h"
#include "sim/arbitration.h"
#include "sim/clock.h"
#include "sim/error_counters.h"
#include "sim/faults.h"
#include "sim/node.h"
#include "sim/trace.h"
#include "sync/input.h"
#include "sync/sync_wire.h"

namespace sim {

/// How a line is built.
struct LineSettings {
  std::uint32_t bits_per_second = 1'000'000;  ///< 10,000..1,000,000
  ClockKind clock = ClockKind::virtual_time;
  std::uint64_t seed = 1;           ///< of all that happens by chance
  std::size_t transmit_queue = 10;  ///< frames of the user that may wait, 1..4096
  std::size_t receive_queue = 256;  ///< frames that may wait for `receive`, 1..65536
  std::vector<Fault> faults;
  /// For faults that name nodes or change answers; null: none does. Must outlive the line.
  const FaultProtocol* protocol = nullptr;
  TraceSink* trace = nullptr;  ///< told everything, if given; must outlive the line
  /// Nothing: the line's user is the master. With a node that is the master: the user's number among the
  /// nodes, by which traces and faults name it (but for `silent`, which it never is).
  std::optional<NodeNumber> user_number;
};

/// What a line has counted since its start.
struct LineCounters {
  std::uint64_t frames = 0;              ///< frames that were on the bus whole
  std::uint64_t error_frames = 0;        ///< frames destroyed or sent again by a fault
  std::uint64_t lost_deliveries = 0;     ///< receivers that did not get a frame by a fault
  std::uint64_t dropped_by_nodes = 0;    ///< frames of nodes without room in their controller
  std::uint64_t dropped_injections = 0;  ///< foreign frames without room
  std::uint64_t sync_edges = 0;          ///< SYNC edges that were made
  can::Time busy{};                      ///< time the bus was not free
};

/// A simulated line, seen from its user: bus, SYNC wire, nodes and faults. The user is the master, who makes
/// the SYNC edges, unless a node is: then the edges come to the user as from an input (`take`).
///
/// Frames take the bus one after the other, each for exactly its length in bits. When the bus is free, the
/// lowest identifier of all frames that are ready wins; the user's own frames leave in the order they were
/// sent. A frame reaches all nodes and the user at the end of its last bit (`ReceivedFrame::end`, exact in
/// both clocks); the bus is free 3 bits later. Every frame counts as acknowledged.
///
/// Virtual time: `now` starts at 0 and stands still but for `wait_until`, which lets everything up to its
/// deadline happen. The same nodes, calls and seed give the same course to the nanosecond.
/// Real time: what has happened by the simulated instants is caught up with on every call, so that a late
/// caller sees what was on the bus and when, but cannot change it.
///
/// A frame destroyed by a fault takes its bits up to the CRC and an error frame, and is sent again at once.
/// Error counters follow CAN 2.0: bus-off after 32 failures in a row. A node in bus-off comes back after
/// 128 * 11 bit times by itself, the user that long after `reset`.
///
/// All memory is taken in the constructor. Not thread safe: one thread drives the line.
class Line final : public can::Bus, public sync_line::SyncWire, public sync_line::Input {
 public:
  /// Throws std::invalid_argument when a setting is out of its range or there are more than 32 nodes.
  Line(const LineSettings& settings, std::vector<std::unique_ptr<Node>> nodes);
  Line(const Line&) = delete;
  Line& operator=(const Line&) = delete;

  can::Time now() noexcept override { return clock_.now(); }
  can::Wake wait_until(can::Time deadline) noexcept override;
  bool receive(can::ReceivedFrame& out) noexcept override;
  /// A length over 8 counts as 8. A frame on the bus does not count against the depth of the queue.
  can::SendResult send(const can::Frame& frame) noexcept override;
  /// The edge is at `now`, whatever `due` says: nodes see the lateness of the master's thread.
  void sync_edge(can::Time due) noexcept override;
  /// The edges that a node made and that reached the user, of the newest `kEdgesKept`; on the line's clock,
  /// which in real time is CLOCK_MONOTONIC. An edge wakes nobody, as one at a real input.
  bool take(can::Time near, can::Time& at) noexcept override;
  int error() const noexcept override { return 0; }
  can::ControllerStatus status() noexcept override;
  /// Empties the transmit queue and clears the error counters; always possible. Out of bus-off it takes
  /// 128 * 11 bit times until `status` no longer says bus_off.
  can::ResetResult reset() noexcept override;
  can::ResetResult reset_result() noexcept override { return can::ResetResult::done; }
  can::TimestampSource timestamp_source() noexcept override { return can::TimestampSource::simulation; }

  /// Time on the bus of so many bits, rounded down to whole nanoseconds.
  can::Time bit_times(std::uint64_t bits) const noexcept;

  const LineCounters& counters() const noexcept { return counters_; }
  static constexpr std::size_t kEdgesKept = 16;
  /// Intervals begun so far, that is, SYNC edges that were made.
  std::uint64_t intervals() const noexcept { return counters_.sync_edges; }
  /// The faults and how often they have hit. Faults may be added while the line lives (it allocates).
  FaultSchedule& faults() noexcept { return faults_; }
  /// Node `index` in the order given to the constructor.
  Node& node(std::size_t index) noexcept { return *nodes_[index]; }
  std::size_t node_count() const noexcept { return nodes_.size(); }
  /// Controller state of node `index`.
  can::ControllerStatus node_status(std::size_t index) const noexcept;

 private:
  using NodeMask = std::uint32_t;
  static constexpr std::uint8_t kUser = kMostNodes;         // participants after the nodes 0..31
  static constexpr std::uint8_t kForeign = kMostNodes + 1;  // frames that no participant has sent
  static constexpr unsigned kFramesPerNode = 8;
  static constexpr std::uint64_t kRecoveryBits = std::uint64_t{128} * 11;  // bus-off to error active, CAN 2.0
  static constexpr std::uint64_t bit_of(std::uint8_t participant) { return std::uint64_t{1} << participant; }
  // Calls `action` with the index of every set bit, the lowest first.
  template <class Action>
  static void for_each_bit(std::uint64_t mask, Action&& action) {
    for (; mask != 0; mask &= mask - 1) action(static_cast<std::uint8_t>(std::countr_zero(mask)));
  }

  // The frame on the bus.
  struct Flight {
    PendingFrame pending;
    can::Time start{};
    can::Time end{};   // last bit; corrupted: where the error flag begins
    can::Time free{};  // from here on the next one may start
    FaultSchedule::Fate fate;
    bool abandoned = false;  // its controller was reset meanwhile
  };

  struct Participant {
    ErrorCounters errors;
    can::Time bus_off_until{};
  };

  void join(std::size_t index);
  void advance(can::Time to) noexcept;
  // Lets the first thing happen that is due by `to`; false: there is none.
  bool happen(can::Time to) noexcept;
  can::Time next_due() const noexcept;
  void act(can::Time now) noexcept;
  void edge(can::Time at, std::optional<std::uint8_t> maker) noexcept;
  can::Wake wait_virtual(can::Time deadline) noexcept;
  can::Wake wait_real(can::Time deadline) noexcept;

  std::optional<can::Time> next_start() const noexcept;
  const PendingFrame* winner(can::Time start) const noexcept;
  can::Time next_end() const noexcept;
  void begin(can::Time start) noexcept;
  void finish() noexcept;
  void destroyed() noexcept;
  void trace_error() noexcept;
  void deliver() noexcept;
  void deliver_to_user(bool own) noexcept;
  void send_again() noexcept;
  void count_success() noexcept;
  void count_failure() noexcept;
  void enter_bus_off(std::uint8_t participant) noexcept;
  void leave_bus_off(can::Time now) noexcept;
  void hand_over(std::uint8_t index, const Transmission& transmission, can::Time earliest) noexcept;
  PendingFrame pending(const can::Frame& frame, can::Time ready, std::uint8_t sender) noexcept;
  void inject(can::Time edge) noexcept;
  void apply_silence() noexcept;
  NodeMask nodes_of(NodeSet numbers) const noexcept;
  NodeMask wanting(const can::Frame& frame) const noexcept;
  Sender sender_of(std::uint8_t participant) const noexcept;

  LineClock clock_;
  std::uint32_t bits_per_second_;
  std::vector<std::unique_ptr<Node>> nodes_;
  std::optional<NodeNumber> user_number_;
  std::array<NodeMask, kMostNodes> nodes_by_number_ = {};  // but for those that are the master
  NodeMask masters_ = 0;
  NodeMask timed_ = 0;                // nodes with instants of their own
  std::vector<NodeMask> acceptance_;  // of standard data frames, by identifier
  FaultSchedule faults_;
  TraceSink* trace_;

  std::size_t transmit_depth_;
  TransmitQueue transmit_;  // with room for one more, which comes back when its transmission fails
  PendingFrames waiting_;   // frames of nodes, and foreign ones
  std::vector<can::ReceivedFrame> received_;
  std::array<can::Time, kEdgesKept> edges_ = {};
  std::size_t edges_first_ = 0;
  std::size_t edges_size_ = 0;
  std::size_t received_first_ = 0;
  std::size_t received_size_ = 0;

  std::array<Participant, kMostNodes + 1> participants_ = {};
  std::uint64_t unclean_ = 0;  // participants with an error counter over 0
  std::uint64_t bus_off_ = 0;  // participants in bus-off
  NodeMask silent_ = 0;

  std::optional<Flight> flight_;
  can::Time bus_free_{};
  std::uint64_t order_ = 0;
  std::uint64_t dropped_ = 0;
  std::uint64_t queue_full_ = 0;
  std::uint64_t restarts_ = 0;
  LineCounters counters_;
};

}  // namespace sim
