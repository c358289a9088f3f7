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

constexpr Pgn control_of(bool extended) noexcept {
  return extended ? pgn::kExtendedTransportControl : pgn::kTransportControl;
}

}  // namespace

TransportReceiver::TransportReceiver(std::uint8_t window, std::size_t most, FrameQueue& answers)
    : window_(window == 0 ? std::uint8_t{1} : window),
      answers_(answers),
      most_(std::min(most, kMostExtendedBytes)),
      extended_memory_(most_ > kMostBytes ? kExtended * most_ : 0) {}

TransportReceiver::Session* TransportReceiver::find(Address source, Kind kind) noexcept {
  for (Session& session : sessions_) {
    if (session.used && session.source == source && session.kind == kind) return &session;
  }
  return nullptr;
}

/// For a message of the extended form; empty: there is none.
std::span<std::uint8_t> TransportReceiver::free_memory() noexcept {
  for (std::size_t at = 0; at < extended_memory_.size(); at += most_) {
    std::uint8_t* const place = extended_memory_.data() + at;
    const bool taken = std::any_of(sessions_.begin(), sessions_.end(), [&](const Session& session) {
      return session.used && session.data.data() == place;
    });
    if (!taken) return {place, most_};
  }
  return {};
}

/// The session of this source anew, or a free one; null: there is none.
TransportReceiver::Session* TransportReceiver::begin(const Identifier& from, Pgn number, std::uint32_t size,
                                                     Kind kind, Time now) noexcept {
  Session* session = find(from.source, kind);
  if (session != nullptr) {
    give_up(*session);
  } else {
    const auto free = std::find_if(sessions_.begin(), sessions_.end(), [](auto& one) { return !one.used; });
    if (free == sessions_.end()) {
      ++counters_.refused;
      return nullptr;
    }
    session = &*free;
  }
  const std::span<std::uint8_t> memory =
      kind == Kind::extended ? free_memory() : std::span<std::uint8_t>(session->own_memory);
  if (memory.empty()) {
    ++counters_.refused;
    return nullptr;
  }
  session->used = true;
  session->message = ++messages_;
  session->kind = kind;
  session->source = from.source;
  session->own = destination_of(from);
  session->number = number;
  session->priority = from.priority;
  session->size = size;
  session->packets = packets_of(size);
  session->most = 255;
  session->next = 1;
  session->window_end = session->packets;
  session->offset = 0;
  session->offset_wanted = false;
  session->gap = false;
  session->asked_again = 0;
  session->repeats = 0;
  session->until = now + kT1;
  session->data = memory;
  return session;
}

void TransportReceiver::refuse(const Identifier& from, const can::Frame& frame, Address own,
                               AbortReason reason, Kind kind) noexcept {
  answers_.push(abort_frame(own, from.source, pgn_in(frame), reason, control_of(kind == Kind::extended)));
}

void TransportReceiver::announce(const Identifier& from, const can::Frame& frame, Time now) noexcept {
  if (!is_announcement(frame)) {
    ++counters_.refused;
    return;
  }
  (void)begin(from, pgn_in(frame), size_in(frame), Kind::broadcast, now);
}

void TransportReceiver::request(const Identifier& from, const can::Frame& frame, Address own,
                                Time now) noexcept {
  const auto refused = [&](AbortReason reason) {
    ++counters_.refused;
    refuse(from, frame, own, reason, Kind::connection);
  };
  if (size_in(frame) > kMostBytes) return refused(AbortReason::too_long);
  if (!is_announcement(frame)) return refused(AbortReason::bad_sequence);
  // The same group anew: its sender has begun again. Another: it has one connection at a time.
  const Session* before = find(from.source, Kind::connection);
  if (before != nullptr && before->number != pgn_in(frame)) return refused(AbortReason::busy);
  Session* session = begin(from, pgn_in(frame), size_in(frame), Kind::connection, now);
  if (session == nullptr) return refuse(from, frame, own, AbortReason::no_resources, Kind::connection);
  session->most = frame.data[4] == 0 ? std::uint8_t{255} : frame.data[4];
  ask(*session, now);
}

void TransportReceiver::request_extended(const Identifier& from, const can::Frame& frame, Address own,
                                         Time now) noexcept {
  const auto refused = [&](AbortReason reason) {
    ++counters_.refused;
    refuse(from, frame, own, reason, Kind::extended);
  };
  const std::uint32_t size = number_in(frame, 1, 4);
  if (size > most_) return refused(AbortReason::no_resources);
  if (size <= kMostBytes || !is_pgn(pgn_in(frame))) return refused(AbortReason::bad_sequence);
  const Session* before = find(from.source, Kind::extended);
  if (before != nullptr && before->number != pgn_in(frame)) return refused(AbortReason::busy);
  Session* session = begin(from, pgn_in(frame), size, Kind::extended, now);
  if (session == nullptr) return refuse(from, frame, own, AbortReason::no_resources, Kind::extended);
  ask(*session, now);
}

void TransportReceiver::offset(const Identifier& from, const can::Frame& frame, Time now) noexcept {
  Session* session = find(from.source, Kind::extended);
  if (session == nullptr || session->number != pgn_in(frame) || !session->offset_wanted) return;
  const std::uint32_t count = frame.data[1];
  if (count == 0 || session->next + count - 1 > session->window_end)
    return break_off(*session, AbortReason::wrong_count);
  if (number_in(frame, 2, 3) != session->next - 1) return break_off(*session, AbortReason::wrong_offset);
  session->offset_wanted = false;
  session->offset = session->next - 1;
  session->window_end = session->next + count - 1;
  session->until = now + kT1;
}

/// Asks for the next window.
void TransportReceiver::ask(Session& session, Time now) noexcept {
  const std::uint32_t left = session.packets - session.next + 1;
  const std::uint32_t count = std::min({left, std::uint32_t{window_}, std::uint32_t{session.most}});
  session.window_end = session.next + count - 1;
  session.gap = false;
  session.until = now + kT2;
  const std::uint8_t packets = static_cast<std::uint8_t>(count);
  if (session.kind == Kind::extended) {
    session.offset_wanted = true;
    answers_.push(
        control_frame(session.own, session.source, session.number, Control::extended_cts,
                      {packets, byte_of(session.next, 0), byte_of(session.next, 1), byte_of(session.next, 2)},
                      pgn::kExtendedTransportControl));
    return;
  }
  answers_.push(control_frame(session.own, session.source, session.number, Control::cts,
                              {packets, static_cast<std::uint8_t>(session.next), 0xFF, 0xFF}));
}

/// What was missed is asked for again, a bounded number of times for each packet.
void TransportReceiver::ask_again(Session& session, Time now) noexcept {
  if (session.asked_again != session.next) session.repeats = 0;
  session.asked_again = session.next;
  if (session.repeats == kMostRepeats) return break_off(session, AbortReason::too_many_repeats);
  ++session.repeats;
  ask(session, now);
}

void TransportReceiver::break_off(Session& session, AbortReason reason) noexcept {
  answers_.push(abort_frame(session.own, session.source, session.number, reason,
                            control_of(session.kind == Kind::extended)));
  give_up(session);
}

void TransportReceiver::give_up(Session& session) noexcept {
  session.used = false;
  ++counters_.broken;
}

void TransportReceiver::aborted(Address source, Pgn number, bool extended) noexcept {
  Session* session = find(source, extended ? Kind::extended : Kind::connection);
  if (session != nullptr && session->number == number) give_up(*session);
}

void TransportReceiver::cleared_to_send(Address source, Pgn number, bool extended, Time now) noexcept {
  Session* session = find(source, extended ? Kind::extended : Kind::connection);
  if (session != nullptr && session->number == number) session->until = now + kT2;
}

std::optional<Message> TransportReceiver::packet(const Identifier& from, const can::Frame& frame,
                                                 Time end) noexcept {
  const bool broadcast = destination_of(from) == kGlobalAddress;
  const bool extended = pgn_of(from) == pgn::kExtendedTransportData;
  Session* session =
      find(from.source, extended ? Kind::extended : (broadcast ? Kind::broadcast : Kind::connection));
  if (session == nullptr || frame.dlc != 8 || session->offset_wanted) return std::nullopt;
  const std::uint32_t number = session->offset + frame.data[0];
  if (number < session->next && frame.data[0] != 0) return std::nullopt;  // twice: it is there already
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
  if (number == session->packets) return finish(*session, end);
  ++session->next;
  if (number == session->window_end) ask(*session, end);
  return std::nullopt;
}

/// The last packet is there.
Message TransportReceiver::finish(Session& session, Time end) noexcept {
  session.used = false;
  ++counters_.completed;
  const std::uint32_t size = session.size;
  Transport transport = Transport::connection;
  switch (session.kind) {
    case Kind::broadcast:
      transport = Transport::broadcast;
      break;
    case Kind::connection:
      answers_.push(control_frame(
          session.own, session.source, session.number, Control::acknowledged,
          {byte_of(size, 0), byte_of(size, 1), static_cast<std::uint8_t>(session.packets), 0xFF}));
      break;
    case Kind::extended:
      transport = Transport::extended;
      answers_.push(control_frame(session.own, session.source, session.number, Control::extended_acknowledged,
                                  {byte_of(size, 0), byte_of(size, 1), byte_of(size, 2), byte_of(size, 3)},
                                  pgn::kExtendedTransportControl));
      break;
  }
  return {session.number,
          session.priority,
          session.source,
          session.kind == Kind::broadcast ? kGlobalAddress : session.own,
          transport,
          end,
          session.data.first(size)};
}

void TransportReceiver::drop_connections() noexcept {
  for (Session& session : sessions_) {
    if (session.used && session.kind != Kind::broadcast) give_up(session);
  }
}

void TransportReceiver::advance(Time now) noexcept {
  for (Session& session : sessions_) {
    if (!session.used || session.until > now) continue;
    if (session.gap) {
      ask_again(session, now);
      continue;
    }
    if (session.kind == Kind::broadcast) {
      give_up(session);
    } else {
      break_off(session, AbortReason::timeout);
    }
  }
}

Time TransportReceiver::next_deadline() const noexcept {
  Time next = Time::max();
  for (const Session& session : sessions_) {
    if (session.used) next = std::min(next, session.until);
  }
  return next;
}

std::uint64_t TransportReceiver::coming(Pgn number, Address source) const noexcept {
  for (const Session& session : sessions_) {
    if (session.used && session.number == number && session.source == source) return session.message;
  }
  return 0;
}

bool TransportReceiver::is_coming(std::uint64_t message) const noexcept {
  return std::any_of(sessions_.begin(), sessions_.end(),
                     [&](const Session& one) { return one.used && one.message == message; });
}

std::size_t TransportReceiver::open() const noexcept {
  return static_cast<std::size_t>(
      std::count_if(sessions_.begin(), sessions_.end(), [](const Session& one) { return one.used; }));
}

}  // namespace j1939
