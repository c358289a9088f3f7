#include "j1939/transport_sender.h"

#include <algorithm>

namespace j1939 {
bool TransportSender::has_room(Address destination) const noexcept {
  bool room = false;
  for (const Session& session : sessions_) {
    if (session.step == Step::free) {
      room = true;
    } else if (session.job.destination == destination) {
      return false;
    }
  }
  return room;
}

void TransportSender::begin(const Job& job, Time now) noexcept {
  for (Session& session : sessions_) {
    if (session.step != Step::free) continue;
    session = {};
    session.step = Step::announce;
    session.job = job;
    session.packets = packets_of(job.data.size());
    session.extended = job.data.size() > kMostBytes;
    session.not_before = now;
    return;
  }
}

bool TransportSender::cancel(std::uint64_t id) noexcept {
  for (Session& session : sessions_) {
    if (session.step == Step::free || session.step == Step::over || session.job.id != id) continue;
    if (session.step != Step::announce && session.job.destination != kGlobalAddress)
      say_abort(session, AbortReason::no_resources);
    session.step = Step::free;
    return true;
  }
  return false;
}

void TransportSender::drop() noexcept {
  for (Session& session : sessions_) {
    if (session.step != Step::free && session.step != Step::over) end(session, SendEnd::no_answer, 0, {});
  }
}

bool TransportSender::ready(const Session& session) const noexcept {
  return (session.step == Step::announce || session.step == Step::offset || session.step == Step::packets) &&
         !session.in_controller;
}

/// RTS, BAM, or the offset of a window: what is said before packets.
can::Frame TransportSender::announcement(const Session& session) noexcept {
  const Job& job = session.job;
  const auto size = static_cast<std::uint32_t>(job.data.size());
  const auto saying = [&](const TransportControl::What& what) {
    return frame_of(TransportControl{session.extended, job.number, what}, job.source, job.destination,
                    job.priority);
  };
  if (session.step == Step::offset)
    return saying(DataOffset{static_cast<std::uint8_t>(session.window_end - session.offset), session.offset});
  if (job.destination == kGlobalAddress) return saying(Announcement{size, session.packets});
  return saying(RequestToSend{size, session.packets});
}

std::optional<can::Frame> TransportSender::next_frame(std::size_t index) const noexcept {
  const Session& session = sessions_[index];
  if (!ready(session) || session.not_before > now_) return std::nullopt;
  if (session.step != Step::packets) return announcement(session);
  const Job& job = session.job;
  const std::size_t at = (session.next - std::size_t{1}) * kPacketBytes;
  const Packet packet{static_cast<std::uint8_t>(session.next - session.offset), job.data.subspan(at)};
  return frame_of(packet, session.extended, job.source, job.destination, job.priority);
}

void TransportSender::handed_over(std::size_t index, Time now) noexcept {
  Session& session = sessions_[index];
  if (!ready(session)) return;
  session.in_controller = true;
  const bool broadcast = session.job.destination == kGlobalAddress;
  if (session.step == Step::announce) {
    session.step = broadcast ? Step::packets : Step::wait;
    session.window_end = broadcast ? session.packets : 0;
    session.until = now + kT3;
    return;
  }
  if (session.step == Step::offset) {
    session.step = Step::packets;
    return;
  }
  session.highest = std::max(session.highest, session.next);
  if (session.next != session.window_end) {
    ++session.next;
    return;
  }
  session.step = broadcast ? Step::finished : Step::wait;
  session.until = now + kT3;
}

void TransportSender::sent(std::size_t index, Time end_of_frame) noexcept {
  Session& session = sessions_[index];
  if (!session.in_controller) return;
  session.in_controller = false;
  const bool broadcast = session.job.destination == kGlobalAddress;
  if (broadcast) session.not_before = end_of_frame + spacing_;
  if (session.step == Step::wait) session.until = end_of_frame + kT3;
  if (session.step == Step::finished) end(session, SendEnd::done, 0, end_of_frame);
}

void TransportSender::unseen(std::size_t index, Time now) noexcept {
  Session& session = sessions_[index];
  if (session.in_controller && session.job.destination == kGlobalAddress) {
    end(session, SendEnd::no_answer, 0, {});
  } else {
    sent(index, now);
  }
}

TransportSender::Session* TransportSender::find(Address destination, Pgn number, bool extended) noexcept {
  for (Session& session : sessions_) {
    const bool open = session.step != Step::free && session.step != Step::over;
    if (open && session.extended == extended && session.job.destination == destination &&
        session.job.number == number)
      return &session;
  }
  return nullptr;
}

void TransportSender::clear_to_send(Address from, Pgn number, const ClearToSend& said, bool extended,
                                    Time now) noexcept {
  Session* session = find(from, number, extended);
  if (session == nullptr || session->step == Step::announce) return;
  if (session->step != Step::wait) return break_off(*session, AbortReason::cts_while_sending);
  session->in_controller = false;  // it answers what was sent last
  if (said.count == 0) {           // held
    session->until = now + kT4;
    return;
  }
  const std::uint32_t first = said.first;
  if (first == 0 || first > session->packets || first > session->highest + 1u)
    return break_off(*session, AbortReason::bad_sequence);
  if (first <= session->highest) {
    if (first > session->asked_again) session->repeats = 0;
    session->asked_again = std::max(session->asked_again, first);
    if (++session->repeats > kMostRepeats) return break_off(*session, AbortReason::too_many_repeats);
  }
  session->next = first;
  session->window_end = std::min(first + said.count - 1u, session->packets);
  session->offset = session->extended ? first - 1 : 0;
  session->step = session->extended ? Step::offset : Step::packets;
  session->not_before = now_;
  session->until = Time::max();
}

void TransportSender::acknowledged(Address from, Pgn number, bool extended, Time now) noexcept {
  Session* session = find(from, number, extended);
  if (session == nullptr || session->step != Step::wait || session->highest != session->packets) return;
  end(*session, SendEnd::done, 0, now);
}

void TransportSender::aborted(Address from, Pgn number, const Abort& said, bool extended) noexcept {
  Session* session = find(from, number, extended);
  if (session == nullptr || session->step == Step::announce) return;
  end(*session, SendEnd::aborted, static_cast<std::uint8_t>(said.reason), {});
}

void TransportSender::say_abort(const Session& session, AbortReason reason) noexcept {
  const Job& job = session.job;
  answers_.push(frame_of({session.extended, job.number, Abort{reason}}, job.source, job.destination));
}

void TransportSender::break_off(Session& session, AbortReason reason) noexcept {
  say_abort(session, reason);
  end(session, SendEnd::no_answer, 0, {});
}

void TransportSender::end(Session& session, SendEnd how, std::uint8_t reason, Time sent) noexcept {
  session.step = Step::over;
  session.in_controller = false;
  session.ended = {session.job.id, how, reason, sent};
}

void TransportSender::advance(Time now) noexcept {
  now_ = now;
  for (Session& session : sessions_) {
    if (session.step == Step::wait && session.until <= now) break_off(session, AbortReason::timeout);
  }
}

Time TransportSender::next_deadline() const noexcept {
  Time next = Time::max();
  for (const Session& session : sessions_) {
    if (session.step == Step::wait) next = std::min(next, session.until);
    if (ready(session) && session.not_before > now_) next = std::min(next, session.not_before);
  }
  return next;
}

std::optional<TransportSender::Ended> TransportSender::take_ended() noexcept {
  for (Session& session : sessions_) {
    if (session.step != Step::over) continue;
    session.step = Step::free;
    return session.ended;
  }
  return std::nullopt;
}

std::uint64_t TransportSender::job_at(std::size_t index) const noexcept {
  const Session& session = sessions_[index];
  return session.step == Step::free || session.step == Step::over ? 0 : session.job.id;
}

bool TransportSender::begun(std::uint64_t id) const noexcept {
  return std::any_of(sessions_.begin(), sessions_.end(), [&](const Session& one) {
    return one.step != Step::free && one.step != Step::announce && one.job.id == id;
  });
}

std::size_t TransportSender::open() const noexcept {
  return static_cast<std::size_t>(std::count_if(sessions_.begin(), sessions_.end(), [](const Session& one) {
    return one.step != Step::free && one.step != Step::over;
  }));
}

}  // namespace j1939
