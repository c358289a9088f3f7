#include "sim/faults.h"

namespace sim {
namespace {

// splitmix64: small, good enough to throw dice, and the same on every machine.
std::uint64_t next_random(std::uint64_t& state) {
  state += 0x9E3779B97F4A7C15u;
  std::uint64_t mixed = state;
  mixed = (mixed ^ (mixed >> 30)) * 0xBF58476D1CE4E5B9u;
  mixed = (mixed ^ (mixed >> 27)) * 0x94D049BB133111EBu;
  return mixed ^ (mixed >> 31);
}

double next_uniform(std::uint64_t& state) {
  constexpr double kTwoToMinus53 = 1.0 / 9007199254740992.0;
  return static_cast<double>(next_random(state) >> 11) * kTwoToMinus53;
}

constexpr std::size_t kind_index(FaultKind kind) {
  return static_cast<std::size_t>(kind);
}

NodeSet nodes_meant(const Fault& fault) {
  return fault.node ? NodeSet::of(*fault.node) : NodeSet::all();
}

}  // namespace

std::string_view name(FaultKind kind) noexcept {
  constexpr std::array<std::string_view, kFaultKinds> kNames = {
      "lost", "late", "corrupted", "duplicated", "silent", "wrong_answer", "busy", "missing_sync", "inject"};
  return kNames[kind_index(kind)];
}

FaultSchedule::FaultSchedule(const std::vector<Fault>& faults, std::uint64_t seed,
                             const FaultProtocol* protocol)
    : protocol_(protocol), seed_(seed) {
  for (const Fault& fault : faults) add(fault);
}

std::size_t FaultSchedule::add(const Fault& fault) {
  const std::size_t index = entries_.size();
  std::uint64_t start = seed_ + index * 0xD1B54A32D192ED03u;
  entries_.push_back({fault, next_random(start), 0});
  ++of_kind_[kind_index(fault.kind)];
  return index;
}

void FaultSchedule::replace(std::size_t index, const Fault& fault) noexcept {
  if (index >= entries_.size()) return;
  --of_kind_[kind_index(entries_[index].fault.kind)];
  ++of_kind_[kind_index(fault.kind)];
  entries_[index].fault = fault;
  entries_[index].hits = 0;
}

bool FaultSchedule::in_time(const Entry& entry) const noexcept {
  return interval_ >= entry.fault.from && interval_ <= entry.fault.to;
}

bool FaultSchedule::concerns(const Entry& entry, const can::Frame& frame) const noexcept {
  const Fault& fault = entry.fault;
  if (!in_time(entry) || ((frame.id ^ fault.identifier) & fault.mask) != 0) return false;
  if (fault.extended && *fault.extended != frame.extended) return false;
  return !fault.node || (protocol_ != nullptr && protocol_->node_of(frame) == fault.node);
}

bool FaultSchedule::hit(Entry& entry) noexcept {
  if (entry.hits >= entry.fault.count) return false;
  if (entry.fault.probability < 1.0 && next_uniform(entry.random) >= entry.fault.probability) return false;
  ++entry.hits;
  return true;
}

void FaultSchedule::begin_interval(std::uint64_t number) noexcept {
  interval_ = number;
  silent_ = {};
  if (of_kind_[kind_index(FaultKind::silent)] == 0) return;
  for (Entry& entry : entries_) {
    if (entry.fault.kind != FaultKind::silent || !in_time(entry) || !hit(entry)) continue;
    silent_.add(nodes_meant(entry.fault));
  }
}

NodeSet FaultSchedule::missing_sync() noexcept {
  NodeSet missing;
  if (of_kind_[kind_index(FaultKind::missing_sync)] == 0) return missing;
  for (Entry& entry : entries_) {
    if (entry.fault.kind != FaultKind::missing_sync || !in_time(entry) || !hit(entry)) continue;
    missing.add(nodes_meant(entry.fault));
  }
  return missing;
}

can::Time FaultSchedule::at_hand_over(can::Frame& frame) noexcept {
  can::Time delay{0};
  for (Entry& entry : entries_) {
    const FaultKind kind = entry.fault.kind;
    const bool answer = kind == FaultKind::wrong_answer || kind == FaultKind::busy;
    if ((!answer && kind != FaultKind::late) || !concerns(entry, frame)) continue;
    if (answer && (protocol_ == nullptr || !protocol_->is_answer(frame))) continue;
    if (!hit(entry)) continue;
    if (kind == FaultKind::late) delay += entry.fault.delay;
    if (kind == FaultKind::wrong_answer) protocol_->make_wrong(frame);
    if (kind == FaultKind::busy) protocol_->make_busy(frame);
  }
  return delay;
}

FaultSchedule::Fate FaultSchedule::at_start(const can::Frame& frame, bool repeated) noexcept {
  Fate fate;
  // A destroyed frame is not lost or duplicated as well: those faults wait for its repetition.
  if (of_kind_[kind_index(FaultKind::corrupted)] != 0) {
    for (Entry& entry : entries_) {
      if (entry.fault.kind == FaultKind::corrupted && concerns(entry, frame) && hit(entry)) {
        fate.corrupted = true;
        return fate;
      }
    }
  }
  for (Entry& entry : entries_) {
    const FaultKind kind = entry.fault.kind;
    if (kind == FaultKind::duplicated && !repeated && concerns(entry, frame) && hit(entry)) {
      fate.duplicated = true;
    }
    if (kind == FaultKind::lost && concerns(entry, frame) && hit(entry)) {
      fate.lost.add(entry.fault.receivers);
      fate.lost_to_master = fate.lost_to_master || entry.fault.lost_to_master;
    }
  }
  return fate;
}

const Fault* FaultSchedule::next_injection(std::size_t& cursor) noexcept {
  if (of_kind_[kind_index(FaultKind::inject)] == 0) return nullptr;
  while (cursor < entries_.size()) {
    Entry& entry = entries_[cursor++];
    if (entry.fault.kind == FaultKind::inject && in_time(entry) && hit(entry)) return &entry.fault;
  }
  return nullptr;
}

std::uint64_t FaultSchedule::hits(std::size_t index) const noexcept {
  return index < entries_.size() ? entries_[index].hits : 0;
}

}  // namespace sim
