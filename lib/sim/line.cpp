#include "sim/line.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

namespace sim {
namespace {

constexpr std::uint32_t kIdentifiers = 0x800;
constexpr std::size_t kForeignFrames = 64;  // room for injected frames that wait for the bus
constexpr std::uint64_t kNanosecondsPerSecond = 1'000'000'000;

void require(std::uint64_t value, std::uint64_t least, std::uint64_t most, const char* what) {
  if (value >= least && value <= most) return;
  throw std::invalid_argument(std::string(what) + " is " + std::to_string(value) + ", allowed are " +
                              std::to_string(least) + " to " + std::to_string(most));
}

const LineSettings& checked(const LineSettings& settings, std::size_t nodes) {
  require(settings.bits_per_second, 10'000, 1'000'000, "simulated line: bits_per_second");
  require(settings.transmit_queue, 1, 4096, "simulated line: transmit_queue");
  require(settings.receive_queue, 1, 65536, "simulated line: receive_queue");
  require(nodes, 0, kMostNodes, "simulated line: number of nodes");
  require(settings.user_number.value_or(0), 0, kMostNodes - 1, "simulated line: user_number");
  return settings;
}

}  // namespace

Line::Line(const LineSettings& settings, std::vector<std::unique_ptr<Node>> nodes)
    : clock_(checked(settings, nodes.size()).clock),
      bits_per_second_(settings.bits_per_second),
      nodes_(std::move(nodes)),
      user_number_(settings.user_number),
      acceptance_(kIdentifiers),
      faults_(settings.faults, settings.seed, settings.protocol),
      trace_(settings.trace),
      transmit_depth_(settings.transmit_queue),
      transmit_(settings.transmit_queue + 1),
      waiting_(kMostNodes * kFramesPerNode + kForeignFrames),
      received_(settings.receive_queue) {
  for (std::size_t index = 0; index < nodes_.size(); ++index) join(index);
}

void Line::join(std::size_t index) {
  const NodeMask bit = NodeMask{1} << index;
  if (nodes_[index]->is_master()) {
    masters_ |= bit;
  } else {
    nodes_by_number_[nodes_[index]->node_number()] |= bit;
  }
  for (std::uint32_t identifier = 0; identifier < kIdentifiers; ++identifier) {
    if (nodes_[index]->accepts({.id = identifier})) acceptance_[identifier] |= bit;
  }
  const can::Time now = clock_.now();
  if (const auto first = nodes_[index]->on_join(now))
    hand_over(static_cast<std::uint8_t>(index), *first, now);
  if (nodes_[index]->next_time()) timed_ |= bit;
}

can::Time Line::bit_times(std::uint64_t bits) const noexcept {
  return can::Time(bits * kNanosecondsPerSecond / bits_per_second_);
}

// --- the user's side

can::Wake Line::wait_until(can::Time deadline) noexcept {
  const can::Time now = clock_.now();
  if (deadline <= now) {
    advance(now);
    return can::Wake::deadline;
  }
  return clock_.kind() == ClockKind::virtual_time ? wait_virtual(deadline) : wait_real(deadline);
}

can::Wake Line::wait_virtual(can::Time deadline) noexcept {
  while (received_size_ == 0 && happen(deadline)) {
  }
  if (received_size_ != 0) return can::Wake::frame;
  clock_.sleep_until(deadline);
  return can::Wake::deadline;
}

can::Wake Line::wait_real(can::Time deadline) noexcept {
  while (true) {
    const can::Time now = clock_.now();
    advance(now);
    if (received_size_ != 0) return can::Wake::frame;
    if (deadline <= now) return can::Wake::deadline;
    if (!clock_.sleep_until(std::min(deadline, next_end()))) return can::Wake::interrupted;
  }
}

bool Line::receive(can::ReceivedFrame& out) noexcept {
  if (clock_.kind() == ClockKind::real_time) advance(clock_.now());
  if (received_size_ == 0) return false;
  out = received_[received_first_];
  received_first_ = received_first_ + 1 == received_.size() ? 0 : received_first_ + 1;
  --received_size_;
  return true;
}

can::SendResult Line::send(const can::Frame& frame) noexcept {
  const can::Time now = clock_.now();
  advance(now);
  leave_bus_off(now);
  if ((bus_off_ & bit_of(kUser)) != 0) return can::SendResult::bus_off;
  if (transmit_.size() >= transmit_depth_) {
    ++queue_full_;
    return can::SendResult::queue_full;
  }
  can::Frame sent = frame;
  sent.dlc = std::min<std::uint8_t>(sent.dlc, 8);
  const can::Time delay = faults_.at_hand_over(sent);
  transmit_.push(pending(sent, now + delay, kUser));
  return can::SendResult::queued;
}

void Line::sync_edge(can::Time) noexcept {
  const can::Time now = clock_.now();
  advance(now);
  edge(now, std::nullopt);
}

void Line::edge(can::Time at, std::optional<std::uint8_t> maker) noexcept {
  faults_.begin_interval(counters_.sync_edges++);
  apply_silence();
  const NodeSet missed = faults_.missing_sync();
  const bool to_user = maker && (user_number_ ? !missed.has(*user_number_) : !(missed == NodeSet::all()));
  auto others = static_cast<NodeMask>((std::uint64_t{1} << nodes_.size()) - 1);
  if (maker) others &= ~static_cast<NodeMask>(bit_of(*maker));
  const NodeMask seeing = others & ~nodes_of(missed);
  // An edge that nobody can see is not on the wire.
  if (trace_ != nullptr && (nodes_.empty() || seeing != 0 || to_user)) trace_->sync(at);
  for_each_bit(seeing & ~silent_, [&](std::uint8_t index) { nodes_[index]->on_sync(at); });
  if (to_user) {
    edges_[(edges_first_ + edges_size_) % kEdgesKept] = at;
    if (edges_size_ < kEdgesKept) {
      ++edges_size_;
    } else {
      edges_first_ = (edges_first_ + 1) % kEdgesKept;
    }
  }
  inject(at);
}

bool Line::take(can::Time, can::Time& at) noexcept {
  if (clock_.kind() == ClockKind::real_time) advance(clock_.now());
  if (edges_size_ == 0) return false;
  at = edges_[edges_first_];
  edges_first_ = (edges_first_ + 1) % kEdgesKept;
  --edges_size_;
  return true;
}

can::ControllerStatus Line::status() noexcept {
  const can::Time now = clock_.now();
  advance(now);
  leave_bus_off(now);
  const ErrorCounters& errors = participants_[kUser].errors;
  can::ControllerStatus status;
  status.state = (bus_off_ & bit_of(kUser)) != 0 ? can::ControllerState::bus_off : errors.state();
  status.transmit_errors = errors.transmit_errors();
  status.receive_errors = errors.receive_errors();
  status.bits_per_second = bits_per_second_;
  status.error_frames = counters_.error_frames;
  status.restarts = restarts_;
  status.queue_full = queue_full_;
  status.dropped = dropped_;
  return status;
}

can::ResetResult Line::reset() noexcept {
  const can::Time now = clock_.now();
  advance(now);
  transmit_.clear();
  if (flight_ && flight_->pending.sender == kUser) flight_->abandoned = true;
  Participant& user = participants_[kUser];
  user.errors.clear();
  unclean_ &= ~bit_of(kUser);
  if ((bus_off_ & bit_of(kUser)) != 0) user.bus_off_until = now + bit_times(kRecoveryBits);
  return can::ResetResult::done;
}

can::ControllerStatus Line::node_status(std::size_t index) const noexcept {
  const ErrorCounters& errors = participants_[index].errors;
  can::ControllerStatus status;
  status.state = errors.state();
  status.transmit_errors = errors.transmit_errors();
  status.receive_errors = errors.receive_errors();
  return status;
}

}  // namespace sim
