#include <algorithm>

#include "j1939/node.h"

namespace j1939 {
namespace {

/// Control bytes of an acknowledgement (PGN 59392).
constexpr std::uint8_t kPositive = 0;
constexpr std::uint8_t kNegative = 1;
constexpr std::uint8_t kCannotRespond = 3;

/// For the node's own long answers: the receiver may hold it, but not for ever.
constexpr Time kLongestAnswer = std::chrono::seconds(60);

constexpr Pgn pgn_at(std::span<const std::uint8_t> data, std::size_t at) noexcept {
  return Pgn{data[at]} | Pgn{data[at + 1]} << 8 | Pgn{data[at + 2]} << 16;
}

}  // namespace

std::optional<Node::Delivery> Node::receive(const can::Frame& frame, Time end) noexcept {
  now_ = std::max(now_, end);
  if (!frame.extended || frame.remote || frame.error) {
    ++counters_.foreign;
    return std::nullopt;
  }
  ++counters_.frames;
  const auto delivery = receive_frame(frame, parse(frame.id), end);
  follow_address();
  take_ended();
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
  if (number == pgn::kCommandedAddress || settings_.filter.match(number, source)) return true;
  for (std::size_t i = 0; i < asked_.size(); ++i) {
    const Order& order = asked_[i].order;
    if (order.number == number && order.destination == source) return true;
  }
  return false;
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
      sender_.clear_to_send(from.source, frame, end);
      break;
    case Control::acknowledged:
      sender_.acknowledged(from.source, frame, false, end);
      break;
    case Control::abort:
      sender_.aborted(from.source, frame, false);
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
      sender_.extended_clear_to_send(from.source, frame, end);
      break;
    case Control::extended_acknowledged:
      sender_.acknowledged(from.source, frame, true, end);
      break;
    case Control::abort:
      sender_.aborted(from.source, frame, true);
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
  if (for_us) {
    ++counters_.messages;
    switch (message.number) {
      case pgn::kAddressClaimed:
        if (message.data.size() == 8)
          claim_.claim_received(message.source, name_of(message.data), message.end);
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
    answer_asked(message);
  }
  const auto range = settings_.filter.match(message.number, message.source);
  if (!range) return std::nullopt;
  if (for_us) ++counters_.taken;
  return Delivery{message, *range};
}

void Node::take_request(const Message& message) noexcept {
  const Pgn number = pgn_at(message.data, 0);
  if (number == pgn::kAddressClaimed) {
    claim_.claim_requested(message.end);
    return;
  }
  if (!claim_.address() || message.source >= kNullAddress) return;
  for (const Provided& provided : settings_.provided) {
    if (provided.number == number) return provide(provided, message);
  }
  acknowledge(message, number, kNegative);
}

void Node::provide(const Provided& provided, const Message& request) noexcept {
  if (provided.data.empty()) return;
  const bool for_all = request.destination == kGlobalAddress;
  const Address to = for_all ? kGlobalAddress : request.source;
  if (!send_provided(provided, to)) acknowledge(request, provided.number, kCannotRespond);
}

bool Node::send_provided(const Provided& provided, Address to, bool by_itself) noexcept {
  if (provided.data.size() <= 8) {
    can::Frame frame;
    frame.extended = true;
    frame.id = compose(identifier_of(provided.number, provided.priority, to, *claim_.address()));
    frame.dlc = static_cast<std::uint8_t>(provided.data.size());
    std::copy(provided.data.begin(), provided.data.end(), frame.data.begin());
    if (!by_itself || !replies_.has(frame.id)) replies_.push(frame);
    return true;
  }
  if (sending_.full() || !sender_.has_room(to)) return false;
  const std::uint64_t id = ++jobs_;
  sender_.begin({id, provided.number, provided.priority, *claim_.address(), to, provided.data}, now_);
  sending_.push({{{}, now_ + kLongestAnswer}, id, true});
  return true;
}

/// What went by while no address was held, or the group was on its way still, is left out.
void Node::send_periodic() noexcept {
  for (std::size_t i = 0; i < due_.size(); ++i) {
    const Provided& provided = settings_.provided[i];
    if (provided.period <= Time{0} || provided.data.empty()) continue;
    Time& due = due_[i];
    if (stopped_ || !claim_.address()) {
      due = Time::max();
      continue;
    }
    if (due == Time::max()) due = now_;
    if (due > now_) continue;
    (void)send_provided(provided, kGlobalAddress, true);
    due += ((now_ - due) / provided.period + 1) * provided.period;
  }
}

Time Node::next_periodic() const noexcept {
  Time next = Time::max();
  if (stopped_ || !claim_.address()) return next;
  for (std::size_t i = 0; i < due_.size(); ++i) {
    const Provided& provided = settings_.provided[i];
    if (provided.period > Time{0} && !provided.data.empty())
      next = std::min(next, due_[i] == Time::max() ? now_ : due_[i]);
  }
  return next;
}

/// Requests to all are never answered so: every node would.
void Node::acknowledge(const Message& request, Pgn number, std::uint8_t control) noexcept {
  if (request.destination == kGlobalAddress) return;
  replies_.push(frame_of(
      identifier_of(pgn::kAcknowledgement, 6, kGlobalAddress, *claim_.address()),
      std::array<std::uint8_t, 8>{control, 0xFF, 0xFF, 0xFF, request.source,
                                  static_cast<std::uint8_t>(number), static_cast<std::uint8_t>(number >> 8),
                                  static_cast<std::uint8_t>(number >> 16)}));
}

void Node::take_acknowledgement(const Message& message) noexcept {
  const std::uint8_t control = message.data[0];
  const Address whose = message.data[4];
  if (control > kCannotRespond) return;
  // Of old nodes, which leave the address out, it is that of the destination or all ones.
  if (whose != kGlobalAddress && (!claim_.wanted() || whose != *claim_.wanted())) return;
  const Pgn number = pgn_at(message.data, 5);
  for (std::size_t i = 0; i < asked_.size();) {
    const Order& order = asked_[i].order;
    if (order.number != number || order.destination != message.source) {
      ++i;
      continue;
    }
    end(order, control == kPositive ? Outcome::done : Outcome::refused,
        {.sent = message.end, .code = control});
    asked_.erase(i);
  }
}

/// Gives a message to the requests that wait for it.
void Node::answer_asked(const Message& message) noexcept {
  for (std::size_t i = 0; i < asked_.size();) {
    const Order& order = asked_[i].order;
    if (order.number != message.number || order.destination != message.source) {
      ++i;
      continue;
    }
    const std::size_t size = std::min(message.data.size(), order.memory.size());
    std::copy_n(message.data.begin(), size, order.memory.begin());
    end(order, Outcome::done, {.sent = message.end, .size = static_cast<std::uint32_t>(size)});
    asked_.erase(i);
  }
}

}  // namespace j1939
