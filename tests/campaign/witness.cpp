#include "witness.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <variant>

#include "can/candump.h"

namespace cansyncd::campaign {
namespace {

constexpr std::size_t kRecent = 64;
constexpr std::uint32_t kChannelMask = 0x780;

template <class T>
void keep(std::deque<T>& recent, const T& item) {
  recent.push_back(item);
  if (recent.size() > kRecent) recent.pop_front();
}

std::optional<cansync::Telegram> telegram_in(const can::Frame& frame) {
  const cansync::Decoded decoded = cansync::decode(frame);
  const auto* telegram = std::get_if<cansync::Telegram>(&decoded);
  return telegram != nullptr ? std::optional(*telegram) : std::nullopt;
}

std::uint64_t bits_of(const can::Frame& frame) noexcept {
  std::uint64_t bits = frame.id + (std::uint64_t{frame.dlc} << 32);
  for (const std::uint8_t byte : frame.data) bits = bits * 31 + byte;
  return bits;
}

bool is_actual(const can::Frame& frame) noexcept {
  const std::uint32_t channel = frame.id & kChannelMask;
  return frame.is_standard_data() &&
         (channel == cansync::identifier::actual_one || channel == cansync::identifier::actual_two);
}

std::string in_microseconds(can::Time time) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f us", static_cast<double>(time.count()) / 1000);
  return text;
}

std::string frame_text(const can::Frame& frame) {
  std::array<char, can::kCandumpLineLimit> line{};
  const std::size_t length = can::write_candump_line({}, "", frame, line);
  const std::string text(line.data(), length > 0 ? length - 1 : 0);  // its line feed is left out
  return text.substr(text.rfind(' ') + 1);
}

const char* sender_name(sim::Sender::Kind kind) {
  if (kind == sim::Sender::Kind::master) return "master";
  return kind == sim::Sender::Kind::node ? "slave" : "foreign";
}

}  // namespace

void Witness::edge(can::Time due, can::Time now) noexcept {
  // The first edge is due one interval after the start of the line's clock.
  const auto number = static_cast<cansync::IntervalNumber>(due / plan_.interval() - 1);
  last_edge = Edge{number, due, now};
  keep(recent_edges, *last_edge);
  edges.push_back(*last_edge);
  ++edges_made;
  if (on_line) {
    on_line("SYNC " + std::to_string(number) + " due " + in_microseconds(due) + ", made " +
            in_microseconds(now - due) + " later");
  }
}

void Witness::handed_over(const can::Frame& frame, can::Time now, can::SendResult result) noexcept {
  HandOver hand_over{frame, telegram_in(frame), now, result == can::SendResult::queued, 0, {}};
  if (last_edge) {
    hand_over.interval = last_edge->number;
    hand_over.due = last_edge->due;
  }
  ++(hand_over.accepted ? accepted : refused);
  if (hand_over.accepted && hand_over.telegram) {
    if (const auto* reference = std::get_if<cansync::ReferenceTelegram>(&*hand_over.telegram)) {
      references.released(*reference, hand_over.interval, now);
      keep(questions, Question{reference->channel, reference->polled, hand_over.interval, frame});
    }
    if (const auto* action = std::get_if<cansync::ActionCommand>(&*hand_over.telegram)) {
      stops.handed_over(*action);
    }
    sent.handed_over(*hand_over.telegram);
  }
  handed.push_back(hand_over);
}

void Witness::received(const can::ReceivedFrame& received) noexcept {
  if (received.own || !is_actual(received.frame)) return;
  const auto telegram = telegram_in(received.frame);
  const auto* actual = telegram ? std::get_if<cansync::ActualTelegram>(&*telegram) : nullptr;
  if (actual == nullptr) return;
  const auto begun = std::find_if(begun_.begin(), begun_.end(), [&](const Begun& other) {
    return other.end == received.end && other.frame == received.frame;
  });
  const can::Time start = begun != begun_.end() ? begun->start : received.end;
  keep(arrivals, Arrival{*actual, start, received.end});
  ++arrived[actual->slave.value()][index(actual->channel)];
}

void Witness::frame(const sim::TracedFrame& traced) noexcept {
  ++frames_seen;
  digest(static_cast<std::uint64_t>(traced.start.count()));
  digest(bits_of(traced.frame));
  if (on_line) {
    const can::Time since = last_edge ? traced.start - last_edge->made : traced.start;
    on_line("  " + in_microseconds(since) + " " + sender_name(traced.sender.kind) + " " +
            frame_text(traced.frame));
  }
  if (is_actual(traced.frame)) keep(begun_, Begun{traced.frame, traced.start, traced.end});
  if (traced.sender.kind != sim::Sender::Kind::master) return;
  if (traced.frame.error) {
    // Right behind a frame that others have taken: its controller repeats it. One question, which asks when it is repeated.
    for (Question& question : questions) {
      if (traced.start == last_end_ && question.start == last_start_) question.start = can::Time::max();
    }
    return;
  }
  last_start_ = traced.start;
  last_end_ = traced.end;
  const can::Time since = last_edge ? traced.start - last_edge->made : traced.start;
  frames.push_back({traced.frame, since, line_->intervals()});
  if (traced.frame.id == cansync::identifier::action) {
    const auto telegram = telegram_in(traced.frame);
    const auto* action = telegram ? std::get_if<cansync::ActionCommand>(&*telegram) : nullptr;
    if (action != nullptr) sent.on_bus(*action);
  }
  const std::uint32_t channel = traced.frame.id & kChannelMask;
  if (channel != cansync::identifier::reference_one && channel != cansync::identifier::reference_two) return;
  // The newest one: what was handed to a controller that went to bus-off is never sent.
  const auto question = std::find_if(questions.rbegin(), questions.rend(), [&](const Question& other) {
    return other.frame == traced.frame && other.start == can::Time::max();
  });
  if (question != questions.rend()) question->start = traced.start;
}

void Witness::sync(can::Time at) noexcept {
  digest(static_cast<std::uint64_t>(at.count()));
}

}  // namespace cansyncd::campaign
