#include "cansync/sim/master_node.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sim {
namespace {

using cansync::Channel;
using cansync::ControlCommand;
using cansync::Refusal;
using cansync::Slot;

class DeafListener final : public cansync::MasterListener {
 public:
  void actual_values(cansync::SlaveNumber, const cansync::ActualValues&) noexcept override {}
  void slave_status(cansync::SlaveNumber, const cansync::SlaveStatus&) noexcept override {}
  void state_changed(cansync::State, cansync::State, ControlCommand) noexcept override {}
  void parameter_done(cansync::JobId, const cansync::ParameterResult&) noexcept override {}
  void transfer_progress(cansync::JobId, std::uint32_t) noexcept override {}
  void transfer_done(cansync::JobId, const cansync::TransferResult&) noexcept override {}
  void command_done(cansync::JobId, cansync::Outcome) noexcept override {}
  void event(const cansync::MasterEvent&) noexcept override {}
};

cansync::MasterListener& nobody() noexcept {
  static DeafListener listener;
  return listener;
}

}  // namespace

std::uint32_t value_of(const ReferenceCurve& curve, cansync::IntervalNumber n) noexcept {
  switch (curve.kind) {
    case ReferenceCurve::Kind::none:
      return 0;
    case ReferenceCurve::Kind::constant:
      return static_cast<std::uint32_t>(curve.offset);
    case ReferenceCurve::Kind::ramp:
      // Modulo 2^32 from the beginning, so that nothing overflows.
      return static_cast<std::uint32_t>(curve.offset) +
             static_cast<std::uint32_t>(curve.step) * static_cast<std::uint32_t>(n);
    case ReferenceCurve::Kind::sine:
      break;
  }
  const std::uint32_t period = std::max(curve.period, 1u);
  const double turn = static_cast<double>(n % period) / period;
  const double wave = curve.amplitude * std::sin(2 * std::numbers::pi * turn);
  return static_cast<std::uint32_t>(curve.offset + std::llround(wave));
}

MasterNode::MasterNode(const MasterNodeSettings& settings, cansync::MasterListener* listener)
    : settings_(settings),
      interval_(slot_times(settings.master.bit_rate).interval),
      master_(settings.master, listener != nullptr ? *listener : nobody()),
      references_(settings.references) {}

void MasterNode::set_reference(std::uint8_t value, const ReferenceCurve& curve) noexcept {
  if (value < references_.size()) references_[value] = curve;
}

std::optional<Transmission> MasterNode::on_join(can::Time now) noexcept {
  next_ = now + settings_.first_edge;
  return std::nullopt;
}

std::optional<Transmission> MasterNode::on_frame(const can::Frame& frame, can::Time end) noexcept {
  master_.receive(frame, end - edge_);
  return std::nullopt;
}

std::optional<Transmission> MasterNode::on_sent(const can::Frame& frame, can::Time end) noexcept {
  master_.transmitted(frame, end - edge_);
  return std::nullopt;
}

Deed MasterNode::on_time(can::Time now) noexcept {
  Deed deed;
  if (slot_ == slots_.size()) {
    if (now - next_ > interval_ / 2) {
      // Too late for an edge: the next one would follow too soon. The line keeps its time.
      const auto missed = (now - next_) / interval_ + 1;
      next_interval_ += static_cast<cansync::IntervalNumber>(missed);
      next_ += missed * interval_;
      return deed;
    }
    planned_edge_ = next_;
    deed.sync_edge = begin_interval(now);
  } else {
    const Slot slot = slots_[slot_++].slot;
    if (const auto frame = master_.take(slot)) {
      if (now - edge_ <= master_.latest_start(slot)) {
        master_.sent(slot);
        deed.transmission = Transmission{*frame, now};
      } else {
        master_.left_out(slot);
      }
    }
  }
  next_ = slot_ < slots_.size() ? slots_[slot_].at : planned_edge_ + interval_;
  return deed;
}

/// True when it makes an edge: not while another master is there.
bool MasterNode::begin_interval(can::Time now) noexcept {
  edge_ = now;
  if (settings_.enable && !is_synchronous(master_.state())) {
    for (const ControlCommand command : {ControlCommand::handshake, ControlCommand::take_over_initialisation,
                                         ControlCommand::start_synchronous}) {
      master_.control(command);
    }
  }
  const bool runs = !settings_.enable || (is_synchronous(master_.state()) && !master_.silent());
  if (runs) {
    master_.begin_interval(next_interval_++);
  } else {
    master_.pass_interval(next_interval_++);
  }
  if (settings_.enable && master_.state() == cansync::State::setting_up_master)
    master_.control(ControlCommand::enable_active);
  if (is_active(master_.state())) {
    submit_references();
    submit_routines();
  }
  for (unsigned i = 0; i < cansync::kSlots; ++i) {
    const auto slot = static_cast<Slot>(i);
    slots_[i] = {edge_ + master_.planned_start(slot), slot};
  }
  // Setting up, the command goes first.
  std::sort(slots_.begin(), slots_.end(), [](const PlannedSlot& a, const PlannedSlot& b) {
    return a.at != b.at ? a.at < b.at : a.slot < b.slot;
  });
  slot_ = 0;
  return runs;
}

void MasterNode::submit_references() noexcept {
  for (const Channel channel : {Channel::one, Channel::two}) {
    cansync::ReferenceUpdate update;
    update.channel = channel;
    update.mapping_number = master_.mapping_number();
    update.from_interval = master_.interval();
    for (unsigned i = 0; i < cansync::kWords; ++i) {
      const ReferenceCurve& curve = references_[index(channel) * cansync::kWords + i];
      if (curve.kind == ReferenceCurve::Kind::none) continue;
      update.value[i] = value_of(curve, master_.interval());
      update.valid_mask = static_cast<std::uint8_t>(update.valid_mask | (1u << i));
    }
    if (update.valid_mask != 0 && master_.submit(update) != Refusal::none) ++refused_;
  }
}

Refusal MasterNode::submit(const MasterRoutine::Request& request) noexcept {
  if (const auto* parameter = std::get_if<cansync::ParameterRequest>(&request))
    return master_.submit(*parameter);
  if (const auto* transfer = std::get_if<cansync::TransferRequest>(&request))
    return master_.submit(*transfer);
  if (const auto* word = std::get_if<cansync::ControlWordRequest>(&request)) return master_.submit(*word);
  return master_.submit(*std::get_if<cansync::BroadcastRequest>(&request));
}

void MasterNode::submit_routines() noexcept {
  const cansync::IntervalNumber now = master_.interval();
  for (const MasterRoutine& routine : settings_.routines) {
    if (now < routine.from) continue;
    const bool due = routine.every == 0 ? now == routine.from : (now - routine.from) % routine.every == 0;
    if (!due) continue;
    if (submit(routine.request) != Refusal::none) ++refused_;
  }
}

}  // namespace sim
