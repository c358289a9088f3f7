#include "j1939/node.h"

#include <algorithm>
#include <span>
#include <utility>

namespace j1939 {
namespace {

constexpr bool tells_of_faults(Pgn number) noexcept {
  return number == pgn::kActiveFaults || number == pgn::kPreviousFaults;
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
    if (!for_us || from.source >= kNullAddress) return std::nullopt;
    if (const auto said = transport_control_in(frame)) {
      transport_control(*said, from, end);
    } else {
      ++(frame.dlc != 8 ? counters_.wrong_length : counters_.unknown);
    }
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

void Node::transport_control(const TransportControl& said, const Identifier& from, Time end) noexcept {
  if (destination_of(from) == kGlobalAddress) {
    // Only what somebody wants takes a place.
    const auto* announced = std::get_if<Announcement>(&said.what);
    if (announced != nullptr && wanted(said.number, from.source))
      receiver_.announce(from, said.number, *announced, end);
    return;
  }
  TransportSender& sender = outbox_.packets();
  if (const auto* request = std::get_if<RequestToSend>(&said.what)) {
    if (may_begin(said, from.source))
      receiver_.request(from, said.number, *request, said.extended, *claim_.address(), end);
  } else if (const auto* clear = std::get_if<ClearToSend>(&said.what)) {
    sender.clear_to_send(from.source, said.number, *clear, said.extended, end);
  } else if (const auto* offset = std::get_if<DataOffset>(&said.what)) {
    receiver_.offset(from.source, said.number, *offset, end);
  } else if (std::holds_alternative<EndOfMessage>(said.what)) {
    sender.acknowledged(from.source, said.number, said.extended, end);
  } else if (const auto* abort = std::get_if<Abort>(&said.what)) {
    sender.aborted(from.source, said.number, *abort, said.extended);
    receiver_.aborted(from.source, said.number, said.extended);
  }
}

/// Somebody here takes what a connection is asked for; who asks is told when not.
bool Node::may_begin(const TransportControl& said, Address source) noexcept {
  if (!claim_.address()) return false;
  if (wanted(said.number, source)) return true;
  replies_.push(
      frame_of({said.extended, said.number, Abort{AbortReason::no_resources}}, *claim_.address(), source));
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
      if (const auto name = claimed_name_in(message.data)) {
        claim_.claim_received(message.source, *name, message.end);
      } else {
        ++counters_.wrong_length;
      }
      break;
    case pgn::kCommandedAddress:
      if (const auto command = commanded_address_in(message.data)) {
        (void)claim_.commanded(command->name, command->address, message.end);
      } else {
        ++counters_.wrong_length;
      }
      break;
    case pgn::kRequest:
      if (const auto number = requested_in(message.data)) {
        take_request(message, *number);
      } else {
        ++counters_.wrong_length;
      }
      break;
    case pgn::kAcknowledgement:
      if (const auto said = acknowledgement_in(message.data)) {
        take_acknowledgement(message, *said);
      } else {
        ++(message.data.size() != 8 ? counters_.wrong_length : counters_.unknown);
      }
      break;
    default:
      break;
  }
  outbox_.requested().answered(message);
}

void Node::take_request(const Message& message, Pgn number) noexcept {
  if (number == pgn::kAddressClaimed) {
    claim_.claim_requested(message.end);
  } else {
    provider_.requested(message, number);
  }
}

void Node::take_acknowledgement(const Message& message, const Acknowledgement& said) noexcept {
  // Of old nodes, which leave the address out, it is that of the destination or all ones.
  if (said.whose != kGlobalAddress && (!claim_.wanted() || said.whose != *claim_.wanted())) return;
  outbox_.requested().acknowledged(message, said);
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
