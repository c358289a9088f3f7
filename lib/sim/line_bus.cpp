// The bus of a simulated line: who gets it, for how long, and who receives what.

#include <algorithm>
#include <variant>

#include "can/frame_length.h"
#include "sim/line.h"

namespace sim {
namespace {

// Destroyed in the last bit of the CRC sequence: what follows it is the error frame instead of the tail.
constexpr unsigned kBitsAfterCrc = can::kTailBits;
// SocketCAN's identifier of an error frame that tells of a protocol violation.
constexpr std::uint32_t kProtocolViolation = 0x008;

can::Frame error_frame() {
  can::Frame frame;
  frame.error = true;
  frame.id = kProtocolViolation;
  frame.dlc = 8;
  return frame;
}

}  // namespace

void Line::advance(can::Time to) noexcept {
  while (happen(to)) {
  }
}

bool Line::happen(can::Time to) noexcept {
  const can::Time due = next_due();
  // In virtual time the clock goes along; elsewhere, and when catching up, it is there already.
  const auto reach = [this](can::Time instant) {
    if (clock_.kind() == ClockKind::virtual_time) clock_.sleep_until(instant);
  };
  if (flight_) {
    if (flight_->end <= to && flight_->end <= due) {
      reach(flight_->end);
      finish();
      return true;
    }
  } else if (const auto start = next_start(); start && *start < to && *start < due) {
    // Strictly before: at that instant itself the caller, or a node, may still send and take part in the
    // arbitration.
    begin(*start);
    return true;
  }
  if (due > to) return false;
  reach(due);
  act(due);
  return true;
}

can::Time Line::next_due() const noexcept {
  can::Time due = can::Time::max();
  for_each_bit(timed_,
               [&](std::uint8_t index) { due = std::min(due, nodes_[index]->next_time().value_or(due)); });
  return due;
}

void Line::act(can::Time now) noexcept {
  for_each_bit(timed_, [&](std::uint8_t index) {
    if (nodes_[index]->next_time().value_or(can::Time::max()) > now) return;
    const Deed deed = nodes_[index]->on_time(now);
    if (deed.sync_edge) edge(now, index);
    if (deed.transmission && ((bus_off_ | silent_) & bit_of(index)) == 0)
      hand_over(index, *deed.transmission, now);
  });
}

std::optional<can::Time> Line::next_start() const noexcept {
  std::optional<can::Time> ready = waiting_.earliest();
  if (const PendingFrame* first = transmit_.front())
    ready = ready ? std::min(*ready, first->ready) : first->ready;
  if (!ready) return std::nullopt;
  return std::max(*ready, bus_free_);
}

const PendingFrame* Line::winner(can::Time start) const noexcept {
  const PendingFrame* best = waiting_.winner(start);
  const PendingFrame* own = transmit_.front();
  if (own == nullptr || own->ready > start) return best;
  return best == nullptr || wins(*own, *best) ? own : best;
}

can::Time Line::next_end() const noexcept {
  const can::Time due = next_due();
  if (flight_) return std::min(flight_->end, due);
  const auto start = next_start();
  if (!start) return due;
  return std::min(*start + bit_times(winner(*start)->bits - can::kInterframeBits), due);
}

void Line::begin(can::Time start) noexcept {
  leave_bus_off(start);
  const PendingFrame* chosen = winner(start);
  Flight flight;
  flight.pending = *chosen;
  if (chosen->sender == kUser) {
    transmit_.pop();
  } else {
    waiting_.remove(*chosen);
  }
  const PendingFrame& pending = flight.pending;
  flight.start = start;
  flight.fate = faults_.at_start(pending.frame, pending.repeated);
  if (flight.fate.corrupted) {
    flight.end = start + bit_times(pending.bits - kBitsAfterCrc);
    flight.free = start + bit_times(pending.bits - kBitsAfterCrc + can::kErrorFrameBits);
  } else {
    const unsigned bits = pending.bits - can::kInterframeBits;
    flight.end = start + bit_times(bits);
    // Duplicated: the sender alone sees an error in the very last bit, so an error frame follows.
    flight.free =
        start + bit_times(bits + (flight.fate.duplicated ? can::kErrorFrameBits : can::kInterframeBits));
    if (trace_ != nullptr) trace_->frame({start, flight.end, pending.frame, sender_of(pending.sender)});
  }
  flight_ = flight;
}

void Line::finish() noexcept {
  const Flight& flight = *flight_;
  leave_bus_off(flight.end);
  bus_free_ = flight.free;
  counters_.busy += flight.free - flight.start;
  if (flight.fate.corrupted) {
    destroyed();
  } else {
    ++counters_.frames;
    deliver();
  }
  flight_.reset();
}

void Line::destroyed() noexcept {
  trace_error();
  count_failure();
  send_again();
}

void Line::trace_error() noexcept {
  ++counters_.error_frames;
  if (trace_ == nullptr) return;
  const can::Time end = flight_->free - bit_times(can::kInterframeBits);
  trace_->frame({flight_->end, end, error_frame(), sender_of(flight_->pending.sender)});
}

void Line::deliver() noexcept {
  const Flight& flight = *flight_;
  const can::Frame& frame = flight.pending.frame;
  const std::uint8_t sender = flight.pending.sender;
  const std::uint64_t own = bit_of(sender);
  const std::uint64_t absent = bus_off_ | silent_ | own;
  const NodeMask lost = nodes_of(flight.fate.lost) | (flight.fate.lost_to_master ? masters_ : 0);
  const bool lost_to_user = user_number_ ? flight.fate.lost.has(*user_number_) : flight.fate.lost_to_master;

  const NodeMask present = wanting(frame) & ~static_cast<NodeMask>(absent);
  counters_.lost_deliveries += static_cast<unsigned>(std::popcount(present & lost));
  for_each_bit(present & ~lost, [&](std::uint8_t index) {
    if (const auto answer = nodes_[index]->on_frame(frame, flight.end)) hand_over(index, *answer, flight.end);
  });
  if (sender != kUser && (bus_off_ & bit_of(kUser)) == 0) {
    if (lost_to_user) {
      ++counters_.lost_deliveries;
    } else {
      deliver_to_user(false);
    }
  }
  if (flight.fate.duplicated) {
    trace_error();
    count_failure();
    send_again();
    return;
  }
  count_success();
  if (sender == kUser && !flight.abandoned) deliver_to_user(true);
  if (sender < nodes_.size()) {
    if (const auto next = nodes_[sender]->on_sent(frame, flight.end)) hand_over(sender, *next, flight.end);
  }
}

void Line::deliver_to_user(bool own) noexcept {
  if (received_size_ == received_.size()) {
    ++dropped_;
    return;
  }
  std::size_t at = received_first_ + received_size_;
  if (at >= received_.size()) at -= received_.size();
  received_[at] = {flight_->pending.frame, flight_->end, own};
  ++received_size_;
}

void Line::send_again() noexcept {
  PendingFrame again = flight_->pending;
  again.ready = flight_->free;
  again.repeated = again.repeated || flight_->fate.duplicated;
  if (again.sender == kUser) {
    if (!flight_->abandoned && (bus_off_ & bit_of(kUser)) == 0) transmit_.push_front(again);
  } else if (((bus_off_ | silent_) & bit_of(again.sender)) == 0) {
    waiting_.push(again);
  }
}

// --- fault confinement

void Line::count_success() noexcept {
  if (unclean_ == 0) return;
  const std::uint64_t sender = bit_of(flight_->pending.sender);
  const std::uint64_t deaf = bus_off_ | silent_;
  for_each_bit(unclean_ & ~deaf, [&](std::uint8_t participant) {
    ErrorCounters& errors = participants_[participant].errors;
    if (bit_of(participant) == sender) {
      errors.transmitted();
    } else {
      errors.received();
    }
    if (errors.clean()) unclean_ &= ~bit_of(participant);
  });
}

void Line::count_failure() noexcept {
  const std::uint64_t sender = bit_of(flight_->pending.sender);
  const std::uint64_t everybody = ((std::uint64_t{1} << nodes_.size()) - 1) | bit_of(kUser);
  // A duplicated frame is an error in its sender's eyes alone.
  const std::uint64_t concerned = flight_->fate.duplicated ? everybody & sender : everybody;
  for_each_bit(concerned & ~(bus_off_ | silent_), [&](std::uint8_t participant) {
    ErrorCounters& errors = participants_[participant].errors;
    if (bit_of(participant) != sender) {
      errors.receive_failed();
    } else if (participant != kUser || !flight_->abandoned) {
      errors.transmit_failed();
    }
    if (!errors.clean()) unclean_ |= bit_of(participant);
    if (errors.bus_off()) enter_bus_off(participant);
  });
}

void Line::enter_bus_off(std::uint8_t participant) noexcept {
  bus_off_ |= bit_of(participant);
  if (participant == kUser) {
    transmit_.clear();
    participants_[participant].bus_off_until = can::Time::max();  // until it is reset
  } else {
    waiting_.drop(participant);
    participants_[participant].bus_off_until = flight_->free + bit_times(kRecoveryBits);
  }
}

void Line::leave_bus_off(can::Time now) noexcept {
  for_each_bit(bus_off_, [&](std::uint8_t index) {
    Participant& participant = participants_[index];
    if (participant.bus_off_until > now) return;
    participant.errors.clear();
    bus_off_ &= ~bit_of(index);
    if (index == kUser) ++restarts_;
    unclean_ &= ~bit_of(index);
  });
}

// --- frames of the nodes and foreign ones

PendingFrame Line::pending(const can::Frame& frame, can::Time ready, std::uint8_t sender) noexcept {
  return {frame, ready, order_++, arbitration_key(frame), can::frame_bits(frame), sender, false};
}

void Line::hand_over(std::uint8_t index, const Transmission& transmission, can::Time earliest) noexcept {
  if (waiting_.count(index) == kFramesPerNode) {
    ++counters_.dropped_by_nodes;
    return;
  }
  can::Frame frame = transmission.frame;
  frame.dlc = std::min<std::uint8_t>(frame.dlc, 8);
  const can::Time delay = faults_.at_hand_over(frame);
  waiting_.push(pending(frame, std::max(transmission.not_before, earliest) + delay, index));
}

void Line::inject(can::Time edge) noexcept {
  std::size_t cursor = 0;
  while (const Fault* fault = faults_.next_injection(cursor)) {
    if (!waiting_.push(pending(fault->frame, edge + fault->delay, kForeign))) ++counters_.dropped_injections;
  }
}

void Line::apply_silence() noexcept {
  silent_ = nodes_of(faults_.silent());
  for_each_bit(silent_, [&](std::uint8_t index) { waiting_.drop(index); });
}

Line::NodeMask Line::wanting(const can::Frame& frame) const noexcept {
  if (frame.is_standard_data()) return acceptance_[frame.identifier()];
  NodeMask nodes = 0;
  for (std::size_t index = 0; index < nodes_.size(); ++index) {
    if (nodes_[index]->accepts(frame)) nodes |= NodeMask{1} << index;
  }
  return nodes;
}

Line::NodeMask Line::nodes_of(NodeSet numbers) const noexcept {
  NodeMask nodes = 0;
  for_each_bit(numbers.bits, [&](std::uint8_t number) { nodes |= nodes_by_number_[number]; });
  return nodes;
}

Sender Line::sender_of(std::uint8_t participant) const noexcept {
  if (participant == kUser) {
    return user_number_ ? Sender{Sender::Kind::node, *user_number_} : Sender{Sender::Kind::master, {}};
  }
  if (participant == kForeign) return {Sender::Kind::foreign, {}};
  if ((masters_ & bit_of(participant)) != 0) return {Sender::Kind::master, {}};
  return {Sender::Kind::node, nodes_[participant]->node_number()};
}

}  // namespace sim
