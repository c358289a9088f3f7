#include "daemon/j1939/realtime/message_machine.h"

#include <algorithm>
#include <chrono>
#include <variant>

#include "daemon/bus/bus_obstacle.h"

namespace cansyncd {
namespace {

/// Requests taken at once: the work they make must not keep frames waiting.
constexpr unsigned kOrdersAtOnce = 16;
constexpr can::Time kSnapshotPeriod = std::chrono::milliseconds(100);

}  // namespace

void MessageMachine::begin(can::Time now) noexcept {
  watch_.begin(now);
  next_status_ = now;
  next_addresses_ = now;
  node_.start(now);
  exchange_.addresses.write(addresses_);
  changed_ = true;  // nobody has been told how the bus is
}

void MessageMachine::advance(can::Time now) noexcept {
  watch_bus(now);
  take_requests(now);
  node_.advance(now);
}

void MessageMachine::watch_bus(can::Time now) noexcept {
  const ControllerWatch::News news = watch_.turn(now);
  if (news.emptied) node_.controller_emptied();
  if (news.echoes_lost) node_.echoes_lost();
  if (news.changed) changed_ = true;
  // The bus is not asked about a frame that has no place in the controller.
  if (node_.waiting() != 0 && !node_.has_place()) node_.held_back(obstacle_of(watch_.controller()));
}

void MessageMachine::take_requests(can::Time now) noexcept {
  J1939Request request;
  for (unsigned i = 0; i < kOrdersAtOnce && exchange_.done.room() > unanswered_; ++i) {
    if (!exchange_.requests.try_pop(request)) return;
    if (const auto* cancel = std::get_if<CancelMessage>(&request)) {
      (void)node_.cancel(cancel->id);
      continue;
    }
    const auto& order = *std::get_if<j1939::Order>(&request);
    ++unanswered_;
    const j1939::Refusal refusal = node_.submit(order, now);
    if (refusal != j1939::Refusal::none) answer({{.id = order.id}, refusal, {}});
  }
}

void MessageMachine::receive(const can::ReceivedFrame& received) noexcept {
  watch_.add(received.frame);
  if (received.own) {
    node_.echo(received.frame, received.end);
    return;
  }
  if (const auto delivery = node_.receive(received.frame, received.end)) report(*delivery);
}

void MessageMachine::report(const j1939::Node::Delivery& delivery) noexcept {
  const j1939::Message& message = delivery.message;
  MessageReport report;
  report.number = message.number;
  report.priority = message.priority;
  report.source = message.source;
  report.destination = message.destination;
  report.transport = message.transport;
  report.taken = delivery.range.has_value();
  report.range = delivery.range.value_or(0);
  report.size = static_cast<std::uint32_t>(message.data.size());
  report.receive_time = watch_.wall_clock(message.end);
  const bool is_long = message.data.size() > report.data.size();
  const std::size_t pieces = is_long ? pieces_of(message.data.size()) : 0;
  if (exchange_.messages.room() == 0 || exchange_.long_data.room() < pieces) {
    snapshot_.lost += report.taken;
    return;
  }
  if (is_long) {
    for (auto rest = message.data; !rest.empty();) {
      const auto piece = rest.first(std::min(rest.size(), long_data_.size()));
      std::copy(piece.begin(), piece.end(), long_data_.begin());
      (void)exchange_.long_data.try_push(long_data_);
      rest = rest.subspan(piece.size());
    }
  } else {
    std::copy(message.data.begin(), message.data.end(), report.data.begin());
  }
  (void)exchange_.messages.try_push(report);
  pending_ = true;
}

void MessageMachine::handed_over(can::SendResult result) noexcept {
  if (result == can::SendResult::queued) {
    node_.handed_over();
  } else {
    node_.held_back(obstacle_of(result));
  }
}

void MessageMachine::answer(const MessageDone& done) noexcept {
  // There is room: no more orders are taken than have it.
  (void)exchange_.done.try_push(done);
  --unanswered_;
  pending_ = true;
}

void MessageMachine::pass_answers() noexcept {
  while (const auto ended = node_.take_answer()) {
    const bool done = ended->outcome == j1939::Outcome::done;
    answer({*ended, j1939::Refusal::none, done ? watch_.wall_clock(ended->sent) : can::Time{0}});
  }
}

void MessageMachine::tell_claim() noexcept {
  const j1939::AddressClaim& claim = node_.claim();
  const auto wanted = claim.wanted();
  const auto address = static_cast<std::int16_t>(wanted ? *wanted : -1);
  if (claim.state() != snapshot_.claim || address != snapshot_.address ||
      claim.name_twice() != snapshot_.name_twice) {
    changed_ = true;
  }
  snapshot_.claim = claim.state();
  snapshot_.address = address;
  snapshot_.name_twice = claim.name_twice();
  snapshot_.losses = claim.losses();
  snapshot_.intruders = claim.intruders();
}

void MessageMachine::tell_addresses(can::Time now) noexcept {
  const j1939::ClaimTable& table = node_.claim().table();
  if (table.revision() == told_revision_ || now < next_addresses_) return;
  told_revision_ = table.revision();
  next_addresses_ = now + kSnapshotPeriod;
  for (unsigned i = 0; i < j1939::ClaimTable::kAddresses; ++i) {
    const auto name = table.at(static_cast<j1939::Address>(i));
    addresses_.claimed[i] = name.has_value();
    addresses_.names[i] = name.value_or(0);
  }
  exchange_.addresses.write(addresses_);
  pending_ = true;
}

void MessageMachine::publish(can::Time now) noexcept {
  pass_answers();
  tell_claim();
  tell_addresses(now);
  if (changed_ || now >= next_status_) {
    next_status_ = now + kSnapshotPeriod;
    snapshot_.controller = watch_.controller();
    snapshot_.bus_load = watch_.bus_load();
    snapshot_.counters = node_.counters();
    snapshot_.packets = node_.received_packets();
    snapshot_.answers_lost = node_.answers_lost();
    snapshot_.groups_left_out = node_.groups_left_out();
    snapshot_.timestamps = bus_.timestamp_source();
    snapshot_.waiting = static_cast<std::uint32_t>(node_.waiting());
    snapshot_.transports = static_cast<std::uint32_t>(node_.transports());
    exchange_.status.write(snapshot_);
    // Nobody is woken for counters alone.
    if (changed_) pending_ = true;
    changed_ = false;
  }
  if (!pending_) return;
  pending_ = false;
  exchange_.gateway_wake.signal();
}

void MessageMachine::end(can::Time now) noexcept {
  node_.stop();
  pass_answers();
  J1939Request request;
  while (exchange_.done.room() > 0 && exchange_.requests.try_pop(request)) {
    const auto* order = std::get_if<j1939::Order>(&request);
    if (order == nullptr) continue;
    ++unanswered_;
    answer({{.id = order->id, .outcome = j1939::Outcome::stopped}, j1939::Refusal::none, {}});
  }
  changed_ = true;
  publish(now);
}

}  // namespace cansyncd
