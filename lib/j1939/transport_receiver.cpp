#include "j1939/transport_receiver.h"

#include <algorithm>

namespace j1939 {
namespace {

/// 9..1785 bytes in as many packets as they need: less fits one frame and is no message of packets.
constexpr bool is_in_packets(Pgn number, std::uint32_t size, std::uint32_t packets) noexcept {
  return size > 8 && size <= kMostBytes && packets == packets_of(size) && is_pgn(number);
}

}  // namespace

TransportReceiver::TransportReceiver(std::uint8_t window, std::size_t most, FrameQueue& answers)
    : window_(window == 0 ? std::uint8_t{1} : window),
      answers_(answers),
      most_(std::min(most, kMostExtendedBytes)),
      extended_memory_(most_ > kMostBytes ? kExtended * most_ : 0) {}

TransportReceiver::Session* TransportReceiver::find(Address source, Kind kind) noexcept {
  for (Session& session : sessions_) {
    if (session.used() && session.source == source && session.kind == kind) return &session;
  }
  return nullptr;
}

/// For a message of the extended form; empty: there is none.
std::span<std::uint8_t> TransportReceiver::free_memory() noexcept {
  for (std::size_t at = 0; at < extended_memory_.size(); at += most_) {
    std::uint8_t* const place = extended_memory_.data() + at;
    const bool taken = std::any_of(sessions_.begin(), sessions_.end(), [&](const Session& session) {
      return session.used() && session.data.data() == place;
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
    const auto free = std::find_if(sessions_.begin(), sessions_.end(), [](auto& one) { return !one.used(); });
    if (free == sessions_.end()) {
      ++counters_.no_room;
      return nullptr;
    }
    session = &*free;
  }
  const std::span<std::uint8_t> memory =
      kind == Kind::extended ? free_memory() : std::span<std::uint8_t>(session->own_memory);
  if (memory.empty()) {
    ++counters_.no_room;
    return nullptr;
  }
  session->enter(SessionEvent::begun);
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
  session->asked_again = 0;
  session->repeats = 0;
  session->until = now + kT1;
  session->data = memory;
  return session;
}

void TransportReceiver::announce(const Identifier& from, Pgn number, const Announcement& said,
                                 Time now) noexcept {
  if (!is_in_packets(number, said.size, said.packets)) {
    ++counters_.impossible;
    return;
  }
  (void)begin(from, number, said.size, Kind::broadcast, now);
}

std::optional<AbortReason> TransportReceiver::obstacle(Address source, Pgn number, const RequestToSend& said,
                                                       bool extended) noexcept {
  if (extended) {
    if (said.size > most_) return AbortReason::no_resources;
    if (said.size <= kMostBytes || !is_pgn(number)) return AbortReason::bad_sequence;
  } else {
    if (said.size > kMostBytes) return AbortReason::too_long;
    if (!is_in_packets(number, said.size, said.packets)) return AbortReason::bad_sequence;
  }
  // The same group anew: its sender has begun again. Another: it has one connection at a time.
  const Session* before = find(source, extended ? Kind::extended : Kind::connection);
  return before != nullptr && before->number != number ? std::optional(AbortReason::busy) : std::nullopt;
}

std::uint64_t& TransportReceiver::count_of(AbortReason reason) noexcept {
  if (reason == AbortReason::busy) return counters_.busy;
  return reason == AbortReason::no_resources ? counters_.no_room : counters_.impossible;
}

void TransportReceiver::request(const Identifier& from, Pgn number, const RequestToSend& said, bool extended,
                                Address own, Time now) noexcept {
  const auto refuse = [&](AbortReason reason) {
    answers_.push(frame_of(TransportControl{extended, number, Abort{reason}}, own, from.source));
  };
  if (const auto reason = obstacle(from.source, number, said, extended)) {
    ++count_of(*reason);
    return refuse(*reason);
  }
  Session* session = begin(from, number, said.size, extended ? Kind::extended : Kind::connection, now);
  if (session == nullptr) return refuse(AbortReason::no_resources);
  session->most = said.most == 0 ? std::uint8_t{255} : said.most;
  ask(*session, now);
}

void TransportReceiver::offset(Address source, Pgn number, const DataOffset& said, Time now) noexcept {
  Session* session = find(source, Kind::extended);
  if (session == nullptr || session->number != number || session->state != SessionState::offset) return;
  if (said.count == 0 || session->next + said.count - 1 > session->window_end)
    return break_off(*session, AbortReason::wrong_count);
  if (said.offset != session->next - 1) return break_off(*session, AbortReason::wrong_offset);
  session->enter(SessionEvent::offset_came);
  session->offset = said.offset;
  session->window_end = session->next + said.count - 1;
  session->until = now + kT1;
}

/// Says it to the sender.
void TransportReceiver::answer(const Session& session, const TransportControl::What& what) noexcept {
  answers_.push(
      frame_of({session.kind == Kind::extended, session.number, what}, session.own, session.source));
}

/// Asks for the next window.
void TransportReceiver::ask(Session& session, Time now) noexcept {
  const std::uint32_t left = session.packets - session.next + 1;
  const std::uint32_t count = std::min({left, std::uint32_t{window_}, std::uint32_t{session.most}});
  session.window_end = session.next + count - 1;
  session.enter(session.kind == Kind::extended ? SessionEvent::asked_extended : SessionEvent::asked);
  session.until = now + kT2;
  answer(session, ClearToSend{static_cast<std::uint8_t>(count), session.next});
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
  answer(session, Abort{reason});
  give_up(session);
}

void TransportReceiver::give_up(Session& session) noexcept {
  session.enter(SessionEvent::ended);
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
  const auto packet = packet_in(frame);
  if (!packet) ++counters_.wrong_length;
  if (session == nullptr || !packet || session->state == SessionState::offset) return std::nullopt;
  const std::uint32_t number = session->offset + packet->number;
  if (number < session->next && packet->number != 0) return std::nullopt;  // twice: it is there already
  if (number != session->next || number > session->window_end) {
    if (broadcast) {
      give_up(*session);  // nobody can be asked for it
      return std::nullopt;
    }
    session->enter(SessionEvent::packet_missing);
    session->until = end + kT1;
    if (number >= session->window_end) ask_again(*session, end);
    return std::nullopt;
  }
  const std::size_t at = (number - 1u) * kPacketBytes;
  const std::size_t bytes = std::min(kPacketBytes, session->size - at);
  std::copy_n(packet->data.begin(), bytes, session->data.begin() + static_cast<std::ptrdiff_t>(at));
  session->until = end + kT1;
  if (number == session->packets) return finish(*session, end);
  ++session->next;
  if (number == session->window_end) ask(*session, end);
  return std::nullopt;
}

/// The last packet is there.
Message TransportReceiver::finish(Session& session, Time end) noexcept {
  session.enter(SessionEvent::ended);
  ++counters_.completed;
  const bool broadcast = session.kind == Kind::broadcast;
  if (!broadcast) answer(session, EndOfMessage{session.size, session.packets});
  constexpr std::array kTransports = {Transport::broadcast, Transport::connection, Transport::extended};
  return {session.number,
          session.priority,
          session.source,
          broadcast ? kGlobalAddress : session.own,
          kTransports[static_cast<std::size_t>(session.kind)],
          end,
          session.data.first(session.size)};
}

void TransportReceiver::drop_connections() noexcept {
  for (Session& session : sessions_) {
    if (session.used() && session.kind != Kind::broadcast) give_up(session);
  }
}

void TransportReceiver::advance(Time now) noexcept {
  for (Session& session : sessions_) {
    if (!session.used() || session.until > now) continue;
    if (session.state == SessionState::window) {
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
    if (session.used()) next = std::min(next, session.until);
  }
  return next;
}

std::uint64_t TransportReceiver::coming(Pgn number, Address source) const noexcept {
  for (const Session& session : sessions_) {
    if (session.used() && session.number == number && session.source == source) return session.message;
  }
  return 0;
}

bool TransportReceiver::is_coming(std::uint64_t message) const noexcept {
  return std::any_of(sessions_.begin(), sessions_.end(),
                     [&](const Session& one) { return one.used() && one.message == message; });
}

std::size_t TransportReceiver::open() const noexcept {
  return static_cast<std::size_t>(
      std::count_if(sessions_.begin(), sessions_.end(), [](const Session& one) { return one.used(); }));
}

}  // namespace j1939
