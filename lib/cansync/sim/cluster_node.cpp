#include "cansync/sim/cluster_node.h"

#include <algorithm>

namespace sim {
namespace {

using cansync::Slot;
using cansync::UpperSync;

cansync::SlaveSupervisionSettings supervision_of(const ClusterNodeSettings& settings) {
  cansync::SlaveSupervisionSettings result;
  result.interval = slot_times(settings.cluster.upper.bit_rate).interval;
  result.lock_time = settings.lock_time;
  return result;
}

sync_line::PhaseLockSettings lock_of(const ClusterNodeSettings& settings) {
  sync_line::PhaseLockSettings result;
  result.interval = slot_times(settings.cluster.upper.bit_rate).interval;
  result.greatest_step = settings.greatest_step;
  result.holdover = settings.holdover;
  return result;
}

UpperSync followed(sync_line::LockState state) noexcept {
  switch (state) {
    case sync_line::LockState::searching:
      return UpperSync::searching;
    case sync_line::LockState::locked:
      return UpperSync::locked;
    case sync_line::LockState::holdover:
      return UpperSync::holdover;
    case sync_line::LockState::lost:
      break;
  }
  return UpperSync::lost;
}

}  // namespace

ClusterNode::ClusterNode(const ClusterNodeSettings& settings, cansync::SlaveServiceListener& told,
                         cansync::MasterListener& below)
    : settings_(settings),
      service_(settings.service, told),
      cluster_(settings.cluster, service_, below),
      supervision_(supervision_of(settings)),
      lock_(lock_of(settings)) {
  cluster_.start();
}

bool ClusterNode::tracking() const noexcept {
  return lock_.state() == sync_line::LockState::locked || lock_.state() == sync_line::LockState::holdover;
}

// --- the upper line

bool ClusterNode::accepts(const can::Frame& frame) const noexcept {
  namespace identifier = cansync::identifier;
  if (!frame.is_standard_data()) return false;
  const cansync::SlaveSideSettings& settings = cluster_.upper().settings();
  const std::uint32_t id = frame.identifier();
  const std::uint32_t participant = identifier::participant_of(id);
  switch (identifier::channel_of(id)) {
    case identifier::reference_one:
    case identifier::reference_two:
      return true;
    case identifier::command:
      return participant == settings.number.value();
    case identifier::actual_one:
    case identifier::actual_two:
      return participant < cansync::kSlaves && settings.monitored[participant].has_value();
    default:
      return id == identifier::action;
  }
}

void ClusterNode::on_sync(can::Time now) noexcept {
  newest_ = now;
  if (!seen_) lock_.begin(now + slot_times(settings_.cluster.upper.bit_rate).interval + settings_.phase);
  seen_ = true;
  lock_.input(now);
}

std::optional<Transmission> ClusterNode::on_frame(const can::Frame& frame, can::Time end) noexcept {
  if (!seen_) return std::nullopt;
  supervision_.check(end);
  service_.table().set_value(settings_.status_parameter, supervision_.status_word(0x0007));
  // Until the timeline follows them the edges above say when an answer is due.
  const can::Time edge = tracking() ? edge_ : newest_;
  const auto answer = cluster_.receive_above(frame, end - edge);
  if (!answer) return std::nullopt;
  const can::Time late = slow ? slow() : can::Time{};
  const can::Time ready = std::max(end, edge + answer->window.earliest) + settings_.delay + late;
  if (!cluster_.upper().may_start(*answer, ready - edge)) return std::nullopt;
  return Transmission{answer->frame, ready};
}

std::optional<Transmission> ClusterNode::on_sent(const can::Frame& frame, can::Time) noexcept {
  cluster_.upper().sent(frame);
  return std::nullopt;
}

// --- the timeline, and the lower line

std::optional<can::Time> ClusterNode::next_instant() const noexcept {
  if (!seen_ || lower_ == nullptr) return std::nullopt;
  return slot_ < slots_.size() ? std::min(slots_[slot_].at, lock_.next()) : lock_.next();
}

void ClusterNode::act() noexcept {
  if (slot_ < slots_.size() && slots_[slot_].at <= lock_.next()) return send(slots_[slot_++].slot);
  begin_interval();
}

void ClusterNode::begin_interval() noexcept {
  edge_ = lock_.next();
  lock_.advance();
  ++interval_;
  if (tracking()) supervision_.edge(edge_, cluster_.upper().sync_activated());
  service_.area().at(edge_);
  cluster_.follow(followed(lock_.state()));
  cluster_.begin_interval(interval_);
  slot_ = cansync::kSlots;
  if (cluster_.sync_output()) {
    lower_->sync_edge(edge_);
    for (unsigned i = 0; i < cansync::kSlots; ++i) {
      const auto slot = static_cast<Slot>(i);
      slots_[i] = {edge_ + cluster_.lower().planned_start(slot), slot};
    }
    // Setting up, the command goes first.
    std::ranges::stable_sort(slots_, {}, [](const PlannedTelegram& telegram) { return telegram.at; });
    slot_ = 0;
  }
  if (on_interval) on_interval(*this);
}

void ClusterNode::send(Slot slot) noexcept {
  const auto frame = cluster_.take(slot);
  if (!frame) return;
  if (lower_->send(*frame) == can::SendResult::queued) {
    cluster_.lower().sent(slot);
  } else {
    cluster_.lower().left_out(slot);
  }
}

void ClusterNode::advance_lower(can::Time to) noexcept {
  can::ReceivedFrame received;
  do {
    lower_->wait_until(to);
    while (lower_->receive(received)) {
      if (received.own) {
        cluster_.lower().transmitted(received.frame, received.end - edge_);
      } else {
        cluster_.lower().receive(received.frame, received.end - edge_);
      }
    }
  } while (lower_->now() < to);
}

// --- all lines

void LevelRun::run_to(can::Time until) noexcept {
  can::ReceivedFrame unused;
  for (;;) {
    can::Time to = until;
    for (const ClusterNode* gateway : gateways_) to = std::min(to, gateway->next_instant().value_or(until));
    do {
      top_.wait_until(to);
      while (top_.receive(unused)) {
      }
    } while (top_.now() < to);
    for (ClusterNode* gateway : gateways_) gateway->advance_lower(to);
    bool acted = false;
    for (ClusterNode* gateway : gateways_) {
      if (gateway->next_instant().value_or(until + can::Time(1)) > to) continue;
      gateway->act();
      acted = true;
    }
    if (!acted && to == until) return;
  }
}

}  // namespace sim
