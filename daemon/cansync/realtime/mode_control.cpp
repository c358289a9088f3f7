#include "daemon/cansync/realtime/mode_control.h"

namespace cansyncd {

using cansync::ControlCommand;
using cansync::Refusal;
using cansync::State;

/// From the start to waiting for start; what is already past stays.
void ModeControl::initialise() noexcept {
  if (master_.state() == State::start_up) master_.control(ControlCommand::handshake);
  if (master_.state() == State::waiting_for_initialisation) {
    master_.control(ControlCommand::take_over_initialisation);
  }
}

/// What it has to wait for is no refusal; another master is one, since nobody knows when it goes.
Refusal ModeControl::set_up(bool force) noexcept {
  initialise();
  if (master_.state() != State::setting_up_master && sync_allowed() &&
      master_.control(ControlCommand::start_synchronous, force) == Refusal::other_master) {
    return Refusal::other_master;
  }
  target_ = StartTarget::setup;
  waits_for_command_ = false;
  return Refusal::none;
}

void ModeControl::wait_for_command() noexcept {
  if (after_other_master_ == AfterOtherMaster::resume || target_ == StartTarget::none) return;
  if (master_.access() != cansync::BusAccess::other_master) return;
  target_ = StartTarget::none;
  waits_for_command_ = true;
}

void ModeControl::pursue_target() noexcept {
  initialise();
  wait_for_command();
  if (target_ == StartTarget::none) return;
  if (master_.state() == State::waiting_for_start) {
    if (sync_allowed()) master_.control(ControlCommand::start_synchronous);
    return;
  }
  // Refused until the enable rule is met; asked again in the next interval.
  if (target_ == StartTarget::active && master_.state() == State::setting_up_master) {
    master_.control(ControlCommand::enable_active);
  }
}

Refusal ModeControl::run(bool force) noexcept {
  if (master_.state() != State::active_master) {
    const Refusal refusal = master_.control(ControlCommand::enable_active, force);
    if (refusal != Refusal::none) return refusal;
  }
  target_ = StartTarget::active;
  return Refusal::none;
}

Refusal ModeControl::request(Mode mode, bool force) noexcept {
  switch (mode) {
    case Mode::set_up:
      return set_up(force);
    case Mode::run:
      return run(force);
    case Mode::stop:
      target_ = StartTarget::none;
      waits_for_command_ = false;
      master_.control(ControlCommand::cold_restart);
      initialise();
      return Refusal::none;
    case Mode::reset_can:
      if (reset_pending_) return Refusal::queue_full;
      return end_reset(bus_.reset());
    case Mode::restart:
      target_ = configured_;
      waits_for_command_ = false;
      return master_.control(ControlCommand::cold_restart);
  }
  return Refusal::wrong_state;
}

Refusal ModeControl::end_reset(can::ResetResult result) noexcept {
  reset_pending_ = result == can::ResetResult::pending;
  switch (result) {
    case can::ResetResult::done:
      return master_.control(ControlCommand::reset_can);
    case can::ResetResult::not_permitted:
      return Refusal::not_permitted;
    case can::ResetResult::unavailable:
      return Refusal::bus_unavailable;
    case can::ResetResult::pending:
      break;
  }
  return Refusal::none;
}

std::optional<Refusal> ModeControl::finish_reset() noexcept {
  const Refusal refusal = end_reset(bus_.reset_result());
  return reset_pending_ ? std::nullopt : std::optional(refusal);
}

void ModeControl::shut_down() noexcept {
  target_ = StartTarget::none;
  master_.control(ControlCommand::cold_restart);
}

}  // namespace cansyncd
