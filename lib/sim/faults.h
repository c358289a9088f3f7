#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "can/bus.h"
#include "can/frame.h"
#include "sim/fault_protocol.h"
#include "sim/node_set.h"

/// Faults that a simulated line injects, and when. docs/fault-scripts.md explains every kind.
namespace sim {

enum class FaultKind : std::uint8_t {
  lost,          ///< on the bus, but the receivers do not get it
  late,          ///< handed to the sender's controller `delay` later
  corrupted,     ///< destroyed by an error frame, sent again by the controller
  duplicated,    ///< the receivers get it twice
  silent,        ///< the node is off the bus: neither frames nor SYNC reach it, none come from it
  wrong_answer,  ///< an answer is to another question than asked
  busy,          ///< an answer says busy and carries no data
  missing_sync,  ///< the SYNC edge does not reach the node, or any node
  inject,        ///< a foreign frame is sent
};
inline constexpr unsigned kFaultKinds = 9;

/// The name of a kind, as fault scripts write it.
std::string_view name(FaultKind kind) noexcept;

/// One fault. It hits when all its conditions hold: interval, filter, probability, and fewer than `count`
/// hits so far. Interval n begins with the n-th SYNC edge that the master makes, counted from 0; what is
/// before the first edge counts as interval 0.
struct Fault {
  static constexpr std::uint64_t kNoLimit = std::numeric_limits<std::uint64_t>::max();

  FaultKind kind = FaultKind::lost;
  std::uint64_t from = 0;          ///< first interval
  std::uint64_t to = kNoLimit;     ///< last interval
  std::uint64_t count = kNoLimit;  ///< most hits
  double probability = 1.0;        ///< of a hit each time everything else holds, 0..1
  /// Filter: frames that name this node, 0..31, as the line's protocol tells. With `silent` and
  /// `missing_sync`: the node meant.
  std::optional<NodeNumber> node;
  std::uint32_t identifier = 0;        ///< filter: frames with (id & mask) == (identifier & mask)
  std::uint32_t mask = 0;              ///< 0 = any frame
  std::optional<bool> extended;        ///< filter: frames with 29-bit identifiers, or those without
  NodeSet receivers = NodeSet::all();  ///< lost: nodes that do not get it
  bool lost_to_master = true;          ///< lost: the master does not get it either
  can::Time delay{0};                  ///< late: how much; inject: after the SYNC edge
  can::Frame frame;                    ///< inject: what is sent
};

/// The faults of a line with their counters and random numbers. Every fault draws from its own sequence, so
/// that adding one does not change when the others hit. All but construction and `add` is realtime safe.
class FaultSchedule {
 public:
  /// `protocol` must outlive the schedule. Without one no frame names a node and none is an answer.
  FaultSchedule(const std::vector<Fault>& faults, std::uint64_t seed,
                const FaultProtocol* protocol = nullptr);

  /// Adds a fault and returns its index; it may allocate. A silent node is silent from the next SYNC edge
  /// on.
  std::size_t add(const Fault& fault);

  /// Puts another fault in the place of fault `index`: its hits are counted anew, its random numbers go on.
  /// An index out of range changes nothing.
  void replace(std::size_t index, const Fault& fault) noexcept;

  /// The interval `number` begins.
  void begin_interval(std::uint64_t number) noexcept;

  /// Nodes that are off the bus in the running interval.
  NodeSet silent() const noexcept { return silent_; }

  /// Nodes that the SYNC edge of the running interval does not reach. Counts hits: ask once per edge.
  NodeSet missing_sync() noexcept;

  /// A frame is handed to its sender's controller. Returns by how much it is late; may change the frame into
  /// a wrong or busy answer.
  can::Time at_hand_over(can::Frame& frame) noexcept;

  /// What happens to a frame while it is on the bus.
  struct Fate {
    bool corrupted = false;
    bool duplicated = false;
    NodeSet lost;  ///< nodes that do not get it
    bool lost_to_master = false;
  };
  /// A frame's transmission begins. `repeated`: it has been duplicated already and is not again.
  Fate at_start(const can::Frame& frame, bool repeated) noexcept;

  /// The next foreign frame of the running interval at or after index `cursor`, which moves on; null when
  /// there are no more. Counts hits.
  const Fault* next_injection(std::size_t& cursor) noexcept;

  /// Number of faults.
  std::size_t size() const noexcept { return entries_.size(); }
  /// How often fault `index` has hit; an index out of range gives 0. A silent node counts its intervals.
  std::uint64_t hits(std::size_t index) const noexcept;

 private:
  struct Entry {
    Fault fault;
    std::uint64_t random = 0;  // state of its random numbers
    std::uint64_t hits = 0;
  };

  bool in_time(const Entry& entry) const noexcept;
  bool concerns(const Entry& entry, const can::Frame& frame) const noexcept;
  static bool hit(Entry& entry) noexcept;

  const FaultProtocol* protocol_;
  std::vector<Entry> entries_;
  std::array<unsigned, kFaultKinds> of_kind_ = {};
  std::uint64_t seed_;
  std::uint64_t interval_ = 0;
  NodeSet silent_;
};

}  // namespace sim
