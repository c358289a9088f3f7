#include "j1939/node.h"

#include <algorithm>
#include <span>
#include <utility>

namespace j1939 {
namespace {

/// The highest control byte of an acknowledgement (PGN 59392): cannot respond now.
constexpr std::uint8_t kLastAcknowledgement = 3;

constexpr bool tells_of_faults(Pgn number) noexcept {
  return number == pgn::kActiveFaults || number == pgn::kPreviousFaults;
}

constexpr Pgn pgn_at(std::span<const std::uint8_t> data, std::size_t at) noexcept {
  return Pgn{data[at]} | Pgn{data[at + 1]} << 8 | Pgn{data[at + 2]} << 16;
}

}  // namespace

Node::Node(NodeSettings settings)
    : settings_(std::move(settings)),
      claim_(settings_.claim),
      receiver_(settings_.window, settings_.most_bytes, replies_),
      outbox_({settings_.queue, settings_.most_bytes, settings_.spacing}, claim_, replies_, receiver_,
              counters_),
      provider_(std::move(settings_.provided), claim_, replies_, outbox_) {}

void Node::start(Time now) noexcept {
  now_ = now;
  outbox_.time_is(now);
  claim_.start(now);
  follow_address();
}

std::optional<Node::Delivery> Node::receive(const can::Frame& frame, Time end) noexcept {
  now_ = std::max(now_, end);
  outbox_.time_is(end);
  if (!frame.extended || frame.remote || frame.error) {
    ++counters_.foreign;
    return std::nullopt;
  }
  ++counters_.frames;
  const auto delivery = receive_frame(frame, parse(frame.id), end);
  follow_address();
  outbox_.follow_packets();
  return delivery;
}

std::optional<Node::Delivery> Node::receive_frame(const can::Frame& frame, const Identifier& from,
                                                  Time end) noexcept {
  const Pgn number = pgn_of(from);
  const Address destination = destination_of(from);
  const bool for_us = destination == kGlobalAddress || (claim_.wanted() && destination == *claim_.wanted());
  if (number != pgn::kAddressClaimed && claim_.wanted() && from.source == *claim_.wanted())
    claim_.own_address_used(end);
  if (number == pgn::kTransportControl || number == pgn::kExtendedTransportControl) {
    if (for_us && from.source < kNullAddress && frame.dlc == 8) transport_control(frame, from, end);
    return std::nullopt;
  }
  if (number == pgn::kTransportData || number == pgn::kExtendedTransportData) {
    if (!for_us) return std::nullopt;
    const auto message = receiver_.packet(from, frame, end);
    return message ? deliver(*message) : std::nullopt;
  }
  if (!for_us && !settings_.between_others) return std::nullopt;
  last_ = frame;
  return deliver({number, from.priority, from.source, destination, Transport::frame, end,
                  std::span<const std::uint8_t>(last_.data.data(), std::min<std::size_t>(frame.dlc, 8))});
}

bool Node::wanted(Pgn number, Address source) const noexcept {
  return number == pgn::kCommandedAddress || tells_of_faults(number) ||
         settings_.filter.match(number, source) || outbox_.requested().waits_for(number, source);
}

void Node::transport_control(const can::Frame& frame, const Identifier& from, Time end) noexcept {
  const bool broadcast = destination_of(from) == kGlobalAddress;
  const bool extended = pgn_of(from) == pgn::kExtendedTransportControl;
  const auto control = static_cast<Control>(frame.data[0]);
  if (broadcast) {
    // Only what somebody wants takes a place.
    if (!extended && control == Control::bam && wanted(pgn_in(frame), from.source))
      receiver_.announce(from, frame, end);
    return;
  }
  if (extended) return extended_control(frame, from, end);
  switch (control) {
    case Control::rts:
      if (may_begin(frame, from, pgn::kTransportControl))
        receiver_.request(from, frame, *claim_.address(), end);
      break;
    case Control::cts:
      outbox_.packets().clear_to_send(from.source, frame, end);
      break;
    case Control::acknowledged:
      outbox_.packets().acknowledged(from.source, frame, false, end);
      break;
    case Control::abort:
      outbox_.packets().aborted(from.source, frame, false);
      receiver_.aborted(from.source, pgn_in(frame), false);
      break;
    default:
      break;
  }
}

void Node::extended_control(const can::Frame& frame, const Identifier& from, Time end) noexcept {
  switch (static_cast<Control>(frame.data[0])) {
    case Control::extended_rts:
      if (may_begin(frame, from, pgn::kExtendedTransportControl))
        receiver_.request_extended(from, frame, *claim_.address(), end);
      break;
    case Control::extended_offset:
      receiver_.offset(from, frame, end);
      break;
    case Control::extended_cts:
      outbox_.packets().extended_clear_to_send(from.source, frame, end);
      break;
    case Control::extended_acknowledged:
      outbox_.packets().acknowledged(from.source, frame, true, end);
      break;
    case Control::abort:
      outbox_.packets().aborted(from.source, frame, true);
      receiver_.aborted(from.source, pgn_in(frame), true);
      break;
    default:
      break;
  }
}

/// Somebody here takes what a connection is asked for; who asks is told when not.
bool Node::may_begin(const can::Frame& frame, const Identifier& from, Pgn by) noexcept {
  if (!claim_.address()) return false;
  if (wanted(pgn_in(frame), from.source)) return true;
  replies_.push(abort_frame(*claim_.address(), from.source, pgn_in(frame), AbortReason::no_resources, by));
  return false;
}

std::optional<Node::Delivery> Node::deliver(const Message& message) noexcept {
  const bool for_us =
      message.destination == kGlobalAddress || message.destination == claim_.wanted().value_or(kNullAddress);
  if (for_us) take(message);
  const auto range = settings_.filter.match(message.number, message.source);
  if (!range && !(for_us && tells_of_faults(message.number))) return std::nullopt;
  if (range && for_us) ++counters_.taken;
  return Delivery{message, range};
}

void Node::take(const Message& message) noexcept {
  ++counters_.messages;
  switch (message.number) {
    case pgn::kAddressClaimed:
      if (message.data.size() == 8) claim_.claim_received(message.source, name_of(message.data), message.end);
      break;
    case pgn::kCommandedAddress:
      if (message.data.size() == 9)
        (void)claim_.commanded(name_of(message.data), message.data[8], message.end);
      break;
    case pgn::kRequest:
      if (message.data.size() >= 3) take_request(message);
      break;
    case pgn::kAcknowledgement:
      if (message.data.size() == 8) take_acknowledgement(message);
      break;
    default:
      break;
  }
  outbox_.requested().answered(message);
}

void Node::take_request(const Message& message) noexcept {
  const Pgn number = pgn_at(message.data, 0);
  if (number == pgn::kAddressClaimed) {
    claim_.claim_requested(message.end);
  } else {
    provider_.requested(message, number);
  }
}

void Node::take_acknowledgement(const Message& message) noexcept {
  const std::uint8_t control = message.data[0];
  const Address whose = message.data[4];
  if (control > kLastAcknowledgement) return;
  // Of old nodes, which leave the address out, it is that of the destination or all ones.
  if (whose != kGlobalAddress && (!claim_.wanted() || whose != *claim_.wanted())) return;
  outbox_.requested().acknowledged(message, pgn_at(message.data, 5), control);
}

Refusal Node::submit(const Order& order, Time now) noexcept {
  now_ = std::max(now_, now);
  return outbox_.submit(order, now);
}

bool Node::cancel(OrderId id) noexcept {
  return outbox_.cancel(id);
}

std::optional<can::Frame> Node::next_frame() noexcept {
  return outbox_.next_frame();
}

void Node::handed_over() noexcept {
  outbox_.handed_over();
}

void Node::echo(const can::Frame& frame, Time end) noexcept {
  outbox_.echo(frame, end);
}

void Node::echoes_lost() noexcept {
  outbox_.echoes_lost();
}

void Node::controller_emptied() noexcept {
  outbox_.controller_emptied();
  // Nothing is sent with the address until it is claimed anew: no message that waits begins before.
  receiver_.drop_connections();
  replies_.clear();
  claim_.start(now_);
  follow_address();
  outbox_.follow_packets();
}

/// With another address, or none, nothing that was begun with the old one can go on.
void Node::follow_address() noexcept {
  const auto wanted = claim_.wanted();
  if (wanted != own_) {
    if (own_) {
      receiver_.drop_connections();
      replies_.clear();
      outbox_.address_changed();
      replies_.clear();
    }
    own_ = wanted;
  }
  if (!wanted && claim_.state() == ClaimState::cannot_claim) outbox_.no_address_to_come();
}

void Node::advance(Time now) noexcept {
  now_ = now;
  outbox_.time_is(now);
  claim_.advance(now);
  follow_address();
  provider_.advance(now);
  receiver_.advance(now);
  outbox_.advance(now);
}

Time Node::next_deadline() const noexcept {
  return std::min({claim_.next_deadline(), receiver_.next_deadline(), outbox_.next_deadline(),
                   provider_.next_deadline(now_)});
}

std::optional<Answer> Node::take_answer() noexcept {
  return outbox_.answers().take();
}

void Node::stop() noexcept {
  provider_.stop();
  outbox_.stop();
}

}  // namespace j1939
