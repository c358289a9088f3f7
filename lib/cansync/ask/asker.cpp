#include "cansync/ask/asker.h"

#include <algorithm>

#include "cansync/telegram/reply_payload.h"

namespace cansync::ask {
namespace {

/// A program's wake-up may be late by so much.
constexpr Duration kLeastPatience = std::chrono::milliseconds(30);
/// A slave that has known process data answers in its slot of the next interval.
constexpr int kPatientIntervals = 3;

bool is_masters(const can::Frame& frame) noexcept {
  if (!frame.is_standard_data()) return false;
  const std::uint32_t channel = identifier::channel_of(frame.id);
  return frame.id == identifier::action || channel == identifier::reference_one ||
         channel == identifier::reference_two || channel == identifier::command;
}

}  // namespace

Asker::Asker(BitRate rate) noexcept
    : interval_(slot_times(rate).interval),
      patience_(std::max<Duration>(kPatientIntervals * slot_times(rate).interval, kLeastPatience)) {}

void Asker::ask(const Question& question, Duration now) noexcept {
  question_ = question;
  answer_.reset();
  open_ = true;
  waiting_ = false;
  tries_ = 0;
  began_ = now;
  free_at_ = std::max(free_at_, now);
  if (const auto* read = std::get_if<ReadQuestion>(&question)) {
    ParameterRequest request;
    request.slave = read->slave;
    request.number = read->number;
    read_ = ParameterJob(request);
  }
}

std::optional<can::Frame> Asker::take(Duration now) noexcept {
  if (!open_ || answer_ || waiting_ || now < free_at_) return std::nullopt;
  // An upload that stays open would have the master's first transfer refused.
  if (master_heard_ && !std::holds_alternative<CloseQuestion>(question_)) return std::nullopt;
  waiting_ = true;
  ++tries_;
  sent_at_ = now;
  free_at_ = now + interval_;
  balance_.asked(kChannels, asked_slave(question_), interval(now), false);
  return frame_of(question_);
}

void Asker::left_out() noexcept {
  if (!waiting_) return;
  waiting_ = false;
  --tries_;
}

void Asker::receive(const can::Frame& frame, Duration now) noexcept {
  if (is_masters(frame)) {
    master_heard_ = true;
    return;
  }
  const Decoded decoded = decode(frame);
  const auto* telegram = std::get_if<Telegram>(&decoded);
  if (telegram == nullptr) return;
  weigh(*telegram, now);
  if (!open_ || answer_ || tries_ == 0) return;
  const bool reads = std::holds_alternative<ReadQuestion>(question_);
  const SlaveNumber slave = asked_slave(question_);
  if (const auto* reply = std::get_if<ParameterReply>(telegram)) {
    if (reads && reply->slave == slave) parameter(*reply, now);
  } else if (const auto* moved = std::get_if<TransferReply>(telegram)) {
    if (!reads && moved->slave == slave) transfer(*moved, now);
  }
}

/// Would it answer the question that was asked last?
bool Asker::fits(const Telegram& telegram) const noexcept {
  const auto* read = std::get_if<ReadQuestion>(&question_);
  if (const auto* reply = std::get_if<ParameterReply>(&telegram))
    return read != nullptr && read->slave == reply->slave && read->number == reply->number;
  const auto* reply = std::get_if<TransferReply>(&telegram);
  return reply != nullptr && read == nullptr && asked_slave(question_) == reply->slave;
}

/// A second answer comes when the first has ended the question.
void Asker::weigh(const Telegram& telegram, Duration now) noexcept {
  std::optional<SlaveNumber> from;
  if (const auto* reply = std::get_if<ParameterReply>(&telegram)) from = reply->slave;
  if (const auto* reply = std::get_if<TransferReply>(&telegram)) from = reply->slave;
  if (from && !balance_.answered(kChannels, *from, interval(now), fits(telegram))) ++too_many_[from->value()];
}

void Asker::parameter(const ParameterReply& reply, Duration now) noexcept {
  switch (read_.answered(reply, 0)) {
    case Step::ignored:
      return;
    case Step::again:
      return again(now);
    case Step::ended:
      break;
  }
  const ParameterResult& result = read_.result();
  if (result.outcome == Outcome::slave_error)
    end({Answer::Kind::refused, 0, false, static_cast<std::uint16_t>(result.error), 0});
  else
    end({Answer::Kind::value, result.value, result.doubleword, 0, 0});
}

void Asker::transfer(const TransferReply& reply, Duration now) noexcept {
  if (reply.busy) return again(now);
  if (reply.error) {
    const auto error = error_answer(reply);
    end({Answer::Kind::refused, 0, false,
         static_cast<std::uint16_t>(error.value_or(TransferError::not_possible)), 0});
    return;
  }
  end({Answer::Kind::taken, 0, false, 0, reply.offset.value()});
}

/// The slave is busy: the same telegram, an interval later.
void Asker::again(Duration now) noexcept {
  if (now - began_ > kBusyTime) return end({Answer::Kind::busy, 0, false, 0, 0});
  waiting_ = false;
  tries_ = 1;
}

std::optional<Answer> Asker::answer(Duration now) noexcept {
  if (!answer_ && waiting_ && now - sent_at_ > patience_) {
    waiting_ = false;
    if (tries_ >= kTries) end({});
  }
  return answer_;
}

Duration Asker::next() const noexcept {
  return waiting_ ? sent_at_ + patience_ + Duration{1} : free_at_;
}

}  // namespace cansync::ask
