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
    session.not_before = now;
    return;
  }
}

bool TransportSender::cancel(std::uint64_t id) noexcept {
  for (Session& session : sessions_) {
    if (session.step == Step::free || session.step == Step::over || session.job.id != id) continue;
    if (session.step != Step::announce && session.job.destination != kGlobalAddress) {
      answers_.push(abort_frame(session.job.source, session.job.destination, session.job.number,
                                AbortReason::no_resources));
    }
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
  return (session.step == Step::announce || session.step == Step::packets) && !session.in_controller;
}

std::optional<can::Frame> TransportSender::next_frame(std::size_t index) const noexcept {
  const Session& session = sessions_[index];
  if (!ready(session) || session.not_before > now_) return std::nullopt;
  const Job& job = session.job;
  const std::size_t size = job.data.size();
  if (session.step == Step::announce) {
    const bool broadcast = job.destination == kGlobalAddress;
    can::Frame frame = control_frame(
        job.source, job.destination, job.number, broadcast ? Control::bam : Control::rts,
        {static_cast<std::uint8_t>(size), static_cast<std::uint8_t>(size >> 8), session.packets, 0xFF});
    frame.id = compose(identifier_of(pgn::kTransportControl, job.priority, job.destination, job.source));
    return frame;
  }
  std::array<std::uint8_t, 8> bytes;
  bytes.fill(0xFF);
  bytes[0] = session.next;
  const std::size_t at = (session.next - 1u) * kPacketBytes;
  std::copy_n(job.data.begin() + static_cast<std::ptrdiff_t>(at), std::min(kPacketBytes, size - at),
              bytes.begin() + 1);
  return frame_of(identifier_of(pgn::kTransportData, job.priority, job.destination, job.source), bytes);
}

void TransportSender::handed_over(std::size_t index, Time now) noexcept {
  Session& session = sessions_[index];
  if (!ready(session)) return;
  session.in_controller = true;
  const bool broadcast = session.job.destination == kGlobalAddress;
  if (session.step == Step::announce) {
    session.step = broadcast ? Step::packets : Step::wait;
    session.window_end = broadcast ? session.packets : std::uint8_t{0};
    session.until = now + kT3;
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

TransportSender::Session* TransportSender::find(Address destination, Pgn number) noexcept {
  for (Session& session : sessions_) {
    const bool open = session.step != Step::free && session.step != Step::over;
    if (open && session.job.destination == destination && session.job.number == number) return &session;
  }
  return nullptr;
}

void TransportSender::clear_to_send(Address from, const can::Frame& frame, Time now) noexcept {
  Session* session = find(from, pgn_in(frame));
  if (session == nullptr || session->step == Step::announce) return;
  if (session->step != Step::wait) return break_off(*session, AbortReason::cts_while_sending);
  session->in_controller = false;  // it answers what was sent last
  const std::uint8_t count = frame.data[1];
  const std::uint8_t first = frame.data[2];
  if (count == 0) {  // held
    session->until = now + kT4;
    return;
  }
  if (first == 0 || first > session->packets || first > session->highest + 1u)
    return break_off(*session, AbortReason::bad_sequence);
  if (first <= session->highest && ++session->repeats > kMostRepeats)
    return break_off(*session, AbortReason::too_many_repeats);
  session->next = first;
  session->window_end = static_cast<std::uint8_t>(std::min(first + count - 1u, unsigned{session->packets}));
  session->step = Step::packets;
  session->not_before = now_;
  session->until = Time::max();
}

void TransportSender::acknowledged(Address from, const can::Frame& frame, Time now) noexcept {
  Session* session = find(from, pgn_in(frame));
  if (session == nullptr || session->step != Step::wait || session->highest != session->packets) return;
  end(*session, SendEnd::done, 0, now);
}

void TransportSender::aborted(Address from, const can::Frame& frame) noexcept {
  Session* session = find(from, pgn_in(frame));
  if (session == nullptr || session->step == Step::announce) return;
  end(*session, SendEnd::aborted, frame.data[1], {});
}

void TransportSender::break_off(Session& session, AbortReason reason) noexcept {
  answers_.push(abort_frame(session.job.source, session.job.destination, session.job.number, reason));
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
