#include "can/link_watch.h"

#include <algorithm>
#include <cerrno>
#include <chrono>

namespace can {
namespace {

constexpr std::chrono::milliseconds kPeriod{1000};

std::uint8_t counter(std::uint16_t errors) noexcept {
  return static_cast<std::uint8_t>(std::min<std::uint16_t>(errors, 255));
}

ResetResult outcome_of(int error) noexcept {
  if (error == 0) return ResetResult::done;
  return error == -EPERM || error == -EACCES ? ResetResult::not_permitted : ResetResult::unavailable;
}

}  // namespace

LinkState link_state(const LinkFacts& facts, std::uint32_t bits_per_second, bool one_shot,
                     const AdapterPin& adapter) noexcept {
  if (!facts.present || !facts.is_can) return LinkState::missing;
  if (!matches(adapter, facts.adapter)) return LinkState::wrong_adapter;
  if (!facts.up) return LinkState::down;
  if (facts.timing && !keeps_bit_rate(*facts.timing, bits_per_second)) return LinkState::wrong_bit_rate;
  if (facts.listen_only) return LinkState::listen_only;
  if (one_shot && !facts.one_shot.value_or(true)) return LinkState::not_one_shot;
  return LinkState::up;
}

LinkState LinkWatch::state_of(const LinkFacts& facts) const noexcept {
  return link_state(facts, settings_.bits_per_second, settings_.one_shot, settings_.adapter);
}

void LinkWatch::publish(const LinkFacts& facts, std::uint32_t era) {
  // First: who learns of the state by the board finds here what it comes from.
  if (told_ && facts != last_told_) told_(facts);
  if (told_) last_told_ = facts;
  board_.set_bit_rate(facts.timing ? facts.timing->bits_per_second : 0);
  board_.set_one_shot(facts.one_shot.value_or(false));
  LinkBoard::Link link{facts.index, state_of(facts)};
  // What another adapter receives is that of another line: the bus is not opened on it.
  if (!facts.is_can || link.state == LinkState::wrong_adapter) link.index = 0;
  link.socket = sockets_.bound_to(link.index);
  if (link.index != 0 && link.socket < 0) link = {};  // gone again; tried anew at the next look
  board_.set_link(link);
  sockets_.close_others(board_.socket_in_use());
  LinkBoard::Controller controller;
  controller.state = facts.state.value_or(ControllerState::error_active);
  controller.transmit_errors = counter(facts.transmit_errors);
  controller.receive_errors = counter(facts.receive_errors);
  board_.set_controller(controller, era);
}

/// A bus-off controller that nobody restarts is restarted; in every other state it is stopped and started,
/// which clears its error counters and its queue. A virtual interface has nothing to reset.
ResetResult LinkWatch::reset(const LinkFacts& facts) {
  const LinkState state = state_of(facts);
  if (state == LinkState::missing || state == LinkState::wrong_adapter || !facts.up)
    return ResetResult::unavailable;
  if (!facts.state) return ResetResult::done;
  if (*facts.state == ControllerState::bus_off && facts.restart_ms.value_or(0) == 0) {
    return outcome_of(kernel_.restart(facts.index));
  }
  const int down = kernel_.set_up(facts.index, false);
  if (down != 0) return outcome_of(down);
  const int up = kernel_.set_up(facts.index, true);
  if (up != 0) left_down_ = facts.index;
  return outcome_of(up);
}

void LinkWatch::set_up_again(LinkFacts& facts) {
  if (facts.up || !facts.present || (left_down_ && *left_down_ != facts.index)) left_down_.reset();
  if (!left_down_) return;
  if (kernel_.set_up(facts.index, true) != 0) return;
  left_down_.reset();
  facts = kernel_.read(settings_.interface);
}

LinkFacts LinkWatch::look() {
  std::uint32_t era = board_.era();
  LinkFacts facts = kernel_.read(settings_.interface);
  set_up_again(facts);
  const std::uint32_t wanted = board_.reset_wanted();
  if (wanted != board_.reset_answered()) {
    const ResetResult result = reset(facts);
    era = board_.era();
    facts = kernel_.read(settings_.interface);
    publish(facts, era);
    board_.answer_reset(wanted, result);
    return facts;
  }
  publish(facts, era);
  return facts;
}

void LinkWatch::run(const std::stop_token& stop, const std::function<void(const LinkFacts&)>& told) {
  const std::stop_callback wake(stop, [this] { kernel_.interrupt(); });
  told_ = told;
  while (!stop.stop_requested()) {
    look();
    kernel_.wait(kPeriod);
  }
  told_ = nullptr;
}

}  // namespace can
