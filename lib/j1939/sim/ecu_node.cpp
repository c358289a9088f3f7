#include "j1939/sim/ecu_node.h"

#include <algorithm>
#include <utility>

namespace sim {
namespace {

/// From a reason to a frame: what a small controller needs.
constexpr can::Time kThinking = std::chrono::microseconds(200);

j1939::NodeSettings node_settings(const EcuSettings& settings) {
  j1939::NodeSettings all;
  all.claim = settings.claim;
  all.filter.add({});
  if (!settings.data.empty()) all.provided = {{settings.group, settings.priority, settings.data}};
  return all;
}

}  // namespace

EcuNode::EcuNode(EcuSettings settings)
    : number_(settings.number), settings_(std::move(settings)), node_(node_settings(settings_)) {}

std::optional<Transmission> EcuNode::next(can::Time now) noexcept {
  node_.advance(now);
  while (node_.take_answer()) under_way_ = false;
  if (in_flight_) return std::nullopt;
  const auto frame = node_.next_frame();
  if (!frame) return std::nullopt;
  node_.handed_over();
  in_flight_ = true;
  return Transmission{*frame, now + kThinking};
}

std::optional<Transmission> EcuNode::on_join(can::Time now) noexcept {
  node_.start(now);
  if (!settings_.data.empty() && settings_.period.count() > 0) next_message_ = now + settings_.period;
  return next(now);
}

std::optional<Transmission> EcuNode::on_frame(const can::Frame& frame, can::Time end) noexcept {
  (void)node_.receive(frame, end);
  return next(end);
}

std::optional<Transmission> EcuNode::on_sent(const can::Frame& frame, can::Time end) noexcept {
  in_flight_ = false;
  node_.echo(frame, end);
  return next(end);
}

std::optional<can::Time> EcuNode::next_time() const noexcept {
  return std::min(node_.next_deadline(), next_message_);
}

void EcuNode::send_message(can::Time now) noexcept {
  next_message_ = now + settings_.period;
  if (under_way_) return;
  if (settings_.counts) ++settings_.data[0];
  const j1939::Order order{.id = 1,
                           .number = settings_.group,
                           .priority = settings_.priority,
                           .destination = settings_.destination,
                           .timeout = std::chrono::seconds(60),
                           .memory = settings_.data};
  under_way_ = node_.submit(order, now) == j1939::Refusal::none;
}

Deed EcuNode::on_time(can::Time now) noexcept {
  node_.advance(now);
  if (next_message_ <= now) send_message(now);
  return {false, next(now)};
}

}  // namespace sim
