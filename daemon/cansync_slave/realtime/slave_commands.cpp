#include "daemon/cansync_slave/realtime/slave_commands.h"

#include <utility>
#include <variant>

namespace cansyncd {

using cansync::ControlCommand;
using cansync::State;

void SlaveCommands::wait_for_start() noexcept {
  (void)slave_.control(ControlCommand::handshake);
  (void)slave_.control(ControlCommand::take_over_initialisation);
}

void SlaveCommands::set_up() noexcept {
  wait_for_start();
  if (target_ != SlaveTarget::none) (void)slave_.control(ControlCommand::start_synchronous);
  if (target_ == SlaveTarget::active) (void)slave_.control(ControlCommand::enable_active);
}

std::optional<SlaveOrderDone> SlaveCommands::take() noexcept {
  if (reset_) {
    const SlaveRefusal refusal = end_reset(bus_.reset_result());
    if (refusal == SlaveRefusal::reset_under_way) return std::nullopt;
    return SlaveOrderDone{*std::exchange(reset_, std::nullopt), refusal};
  }
  SlaveOrder order;
  if (!exchange_.commands.try_pop(order)) return std::nullopt;
  const auto* mode = std::get_if<SlaveModeOrder>(&order);
  const bool resets = mode != nullptr && mode->mode == SlaveMode::reset_can;
  if (of_cluster_ && !resets) return SlaveOrderDone{order, SlaveRefusal::of_cluster};
  if (mode == nullptr) {
    set(order);
    return SlaveOrderDone{order, SlaveRefusal::none};
  }
  const SlaveRefusal refusal = give(*mode);
  if (refusal != SlaveRefusal::reset_under_way) return SlaveOrderDone{order, refusal};
  reset_ = *mode;
  return std::nullopt;
}

std::optional<SlaveOrderDone> SlaveCommands::take_stopped() noexcept {
  if (reset_) {
    const SlaveModeOrder order = *std::exchange(reset_, std::nullopt);
    return SlaveOrderDone{order, SlaveRefusal::none, can::JobKnown::handed_over};
  }
  SlaveOrder order;
  if (!exchange_.commands.try_pop(order)) return std::nullopt;
  return SlaveOrderDone{order, SlaveRefusal::none, can::JobKnown::not_sent};
}

/// A mapping is taken as it is: the gateway has looked at it.
void SlaveCommands::set(const SlaveOrder& order) noexcept {
  if (const auto* mapping = std::get_if<SlaveMappingOrder>(&order)) {
    slave_.set_reference_mapping(mapping->reference);
    slave_.set_actual_mapping(mapping->actual);
  } else if (const auto* listen = std::get_if<SlaveListenOrder>(&order)) {
    slave_.set_monitored(listen->other, listen->mapping);
  }
}

SlaveRefusal SlaveCommands::command(ControlCommand command) noexcept {
  return slave_.control(command) ? SlaveRefusal::none : SlaveRefusal::wrong_state;
}

SlaveRefusal SlaveCommands::give(const SlaveModeOrder& order) noexcept {
  switch (order.mode) {
    case SlaveMode::setup:
      if (slave_.state() == State::setting_up_slave) return SlaveRefusal::none;
      return command(ControlCommand::start_synchronous);
    case SlaveMode::run:
      if (slave_.state() == State::active_slave) return SlaveRefusal::none;
      return command(ControlCommand::enable_active);
    case SlaveMode::stop:
      (void)slave_.control(ControlCommand::cold_restart);
      wait_for_start();
      return SlaveRefusal::none;
    case SlaveMode::restart:
      (void)slave_.control(ControlCommand::cold_restart);
      set_up();
      return SlaveRefusal::none;
    case SlaveMode::reset_can:
      return end_reset(bus_.reset());
  }
  return SlaveRefusal::wrong_state;
}

SlaveRefusal SlaveCommands::end_reset(can::ResetResult result) noexcept {
  switch (result) {
    case can::ResetResult::done:
      return command(ControlCommand::reset_can);
    case can::ResetResult::not_permitted:
      return SlaveRefusal::not_permitted;
    case can::ResetResult::unavailable:
      return SlaveRefusal::no_controller;
    case can::ResetResult::pending:
      break;
  }
  return SlaveRefusal::reset_under_way;
}

}  // namespace cansyncd
