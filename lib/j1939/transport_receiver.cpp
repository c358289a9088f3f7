#include "j1939/transport_receiver.h"

#include <algorithm>

namespace j1939 {
namespace {

constexpr std::uint16_t size_in(const can::Frame& frame) noexcept {
  return static_cast<std::uint16_t>(frame.data[1] | frame.data[2] << 8);
}

/// 9..1785 bytes in as many packets as they need: less fits one frame and is no message of packets.
constexpr bool is_announcement(const can::Frame& frame) noexcept {
  const std::size_t size = size_in(frame);
  return size > 8 && size <= kMostBytes && frame.data[3] == packets_of(size) && is_pgn(pgn_in(frame));
}

}  // namespace

TransportReceiver::Session* TransportReceiver::find(Address source, bool broadcast) noexcept {
  for (Session& session : sessions_) {
    if (session.used && session.source == source && session.broadcast == broadcast) return &session;
  }
  return nullptr;
}

/// The session of this source anew, or a free one; null: there is none.
TransportReceiver::Session* TransportReceiver::begin(const Identifier& from, const can::Frame& frame,
                                                     bool broadcast, Time now) noexcept {
  Session* session = find(from.source, broadcast);
  if (session != nullptr) {
    ++counters_.broken;
  } else {
    const auto free = std::find_if(sessions_.begin(), sessions_.end(), [](auto& one) { return !one.used; });
    if (free == sessions_.end()) {
      ++counters_.refused;
      return nullptr;
    }
    session = &*free;
  }
  session->used = true;
  session->broadcast = broadcast;
  session->source = from.source;
  session->own = destination_of(from);
  session->number = pgn_in(frame);
  session->priority = from.priority;
  session->size = size_in(frame);
  session->packets = frame.data[3];
  session->most = frame.data[4] == 0 ? std::uint8_t{255} : frame.data[4];
  session->next = 1;
  session->window_end = session->packets;
  session->gap = false;
  session->repeats = 0;
  session->until = now + kT1;
  return session;
}

void TransportReceiver::announce(const Identifier& from, const can::Frame& frame, Time now) noexcept {
  if (!is_announcement(frame)) {
    ++counters_.refused;
    return;
  }
  (void)begin(from, frame, true, now);
}

void TransportReceiver::request(const Identifier& from, const can::Frame& frame, Address own,
                                Time now) noexcept {
  const Pgn number = pgn_in(frame);
  const auto refuse = [&](AbortReason reason) {
    ++counters_.refused;
    answers_.push(abort_frame(own, from.source, number, reason));
  };
  if (size_in(frame) > kMostBytes) return refuse(AbortReason::too_long);
  if (!is_announcement(frame)) return refuse(AbortReason::bad_sequence);
  // The same group anew: its sender has begun again. Another: it has one connection at a time.
  const Session* before = find(from.source, false);
  if (before != nullptr && before->number != number) return refuse(AbortReason::busy);
  Session* session = begin(from, frame, false, now);
  if (session == nullptr) {
    answers_.push(abort_frame(own, from.source, number, AbortReason::no_resources));
    return;
  }
  ask(*session, now);
}

/// Asks for the next window.
void TransportReceiver::ask(Session& session, Time now) noexcept {
  const unsigned left = session.packets - session.next + 1u;
  const auto count = static_cast<std::uint8_t>(std::min({left, unsigned{window_}, unsigned{session.most}}));
  session.window_end = static_cast<std::uint8_t>(session.next + count - 1);
  session.gap = false;
  session.until = now + kT2;
  answers_.push(control_frame(session.own, session.source, session.number, Control::cts,
                              {count, session.next, 0xFF, 0xFF}));
}

/// What was missed is asked for again, a bounded number of times for each message.
void TransportReceiver::ask_again(Session& session, Time now) noexcept {
  if (session.repeats == kMostRepeats) {
    answers_.push(abort_frame(session.own, session.source, session.number, AbortReason::too_many_repeats));
    give_up(session);
    return;
  }
  ++session.repeats;
  ask(session, now);
}

void TransportReceiver::give_up(Session& session) noexcept {
  session.used = false;
  ++counters_.broken;
}

void TransportReceiver::aborted(Address source, Pgn number) noexcept {
  Session* session = find(source, false);
  if (session != nullptr && session->number == number) give_up(*session);
}

std::optional<Message> TransportReceiver::packet(const Identifier& from, const can::Frame& frame,
                                                 Time end) noexcept {
  const bool broadcast = destination_of(from) == kGlobalAddress;
  Session* session = find(from.source, broadcast);
  if (session == nullptr || frame.dlc != 8) return std::nullopt;
  const std::uint8_t number = frame.data[0];
  if (number < session->next && number != 0) return std::nullopt;  // twice: it is there already
  if (number != session->next || number > session->window_end) {
    if (broadcast) {
      give_up(*session);  // nobody can be asked for it
      return std::nullopt;
    }
    session->gap = true;
    session->until = end + kT1;
    if (number >= session->window_end) ask_again(*session, end);
    return std::nullopt;
  }
  const std::size_t at = (number - 1u) * kPacketBytes;
  const std::size_t bytes = std::min(kPacketBytes, session->size - at);
  std::copy_n(frame.data.begin() + 1, bytes, session->data.begin() + static_cast<std::ptrdiff_t>(at));
  session->until = end + kT1;
  if (number == session->packets) {
    session->used = false;
    ++counters_.completed;
    if (!broadcast) {
      answers_.push(control_frame(session->own, session->source, session->number, Control::acknowledged,
                                  {static_cast<std::uint8_t>(session->size),
                                   static_cast<std::uint8_t>(session->size >> 8), session->packets, 0xFF}));
    }
    return Message{session->number,
                   session->priority,
                   session->source,
                   broadcast ? kGlobalAddress : session->own,
                   broadcast ? Transport::broadcast : Transport::connection,
                   end,
                   std::span<const std::uint8_t>(session->data.data(), session->size)};
  }
  ++session->next;
  if (number == session->window_end) ask(*session, end);
  return std::nullopt;
}

void TransportReceiver::drop_connections() noexcept {
  for (Session& session : sessions_) {
    if (session.used && !session.broadcast) give_up(session);
  }
}

void TransportReceiver::advance(Time now) noexcept {
  for (Session& session : sessions_) {
    if (!session.used || session.until > now) continue;
    if (session.gap) {
      ask_again(session, now);
      continue;
    }
    if (!session.broadcast)
      answers_.push(abort_frame(session.own, session.source, session.number, AbortReason::timeout));
    give_up(session);
  }
}

Time TransportReceiver::next_deadline() const noexcept {
  Time next = Time::max();
  for (const Session& session : sessions_) {
    if (session.used) next = std::min(next, session.until);
  }
  return next;
}

std::size_t TransportReceiver::open() const noexcept {
  return static_cast<std::size_t>(
      std::count_if(sessions_.begin(), sessions_.end(), [](const Session& one) { return one.used; }));
}

}  // namespace j1939
