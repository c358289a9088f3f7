#include "cansync/slave/slave.h"

#include <utility>

#include "cansync/telegram/reply_payload.h"

namespace cansync {
namespace {

/// The reply to a parameter command (M 3.2.1.3, parameter response).
ParameterReply reply_to(const ParameterCommand& command, const ParameterAnswer& answer) noexcept {
  ParameterReply reply;
  reply.slave = command.slave;
  reply.number = command.number;
  if (answer.busy) {
    put_busy(reply);
  } else if (answer.error != ParameterError::none) {
    put_error(reply, answer.error, command.sub_slave);
  } else if (command.kind == ParameterCommand::Kind::read) {
    put_value(reply, answer.value, answer.doubleword, command.sub_slave);
  } else {
    put_confirmation(reply, command.sub_slave);
  }
  return reply;
}

}  // namespace

Slave::Slave(const SlaveSideSettings& settings, SlaveApplication& application) noexcept
    : references_of_{Unpacking(settings.reference_mapping[0]), Unpacking(settings.reference_mapping[1])},
      settings_(settings),
      application_(application),
      transfers_(settings.number, settings.block_limit, application) {}

bool Slave::control(ControlCommand command) noexcept {
  const std::optional<State> to = next(Role::slave, state_, command);
  if (!to) return false;
  state_ = *to;
  if (!is_synchronous(state_)) {
    transfers_.stop();
    if (pending_ || answered_kind_ == Answered::parameter) application_.parameter_dropped();
    pending_.reset();
    answered_kind_ = Answered::none;
    sync_activated_ = false;
    sync_mode_.reset();
    written_.reset();
    handed_[index(AnswerSlot::response)].reset();
  }
  if (!is_active(state_)) forget_interval();
  return true;
}

void Slave::on_sync(IntervalNumber passed) noexcept {
  for (unsigned channel = 0; channel < kChannels; ++channel) {
    if (release_[channel] == ActualRelease::released) ++counters_[channel].not_asked;
    // What was on the bus at the end of an interval may be told of after the edge.
    if (!handed_[channel] || handed_[channel]->interval == interval_) continue;
    ++counters_[channel].lost;
    handed_[channel].reset();
  }
  interval_ += passed;
  // An interval that passed without its edge had no process data to speak of.
  had_process_data_ = process_data_;
  process_data_ = false;
  forget_interval();
}

void Slave::forget_interval() noexcept {
  fresh_ = {};
  release_ = {};
  heard_ = {};
}

void Slave::release_actual(Channel channel, const Values& values) noexcept {
  const unsigned first = index(channel) * kWords;
  for (unsigned i = first; i < first + kWords; ++i) actual_[i] = values[i];
  ActualCounters& counters = counters_[index(channel)];
  ++counters.released;
  if (release_[index(channel)] == ActualRelease::released) ++counters.not_asked;
  release_[index(channel)] = ActualRelease::released;
}

void Slave::withdraw_actual(Channel channel) noexcept {
  ActualRelease& release = release_[index(channel)];
  if (release != ActualRelease::released) return;
  ++counters_[index(channel)].not_asked;
  release = ActualRelease::none;
}

std::optional<SlaveAnswer> Slave::receive(const can::Frame& frame, Duration since_sync) noexcept {
  const Decoded decoded = decode(frame);
  const auto* telegram = std::get_if<Telegram>(&decoded);
  if (telegram == nullptr) return std::nullopt;
  return receive(*telegram, since_sync);
}

std::optional<SlaveAnswer> Slave::receive(const Telegram& telegram, Duration since_sync) noexcept {
  const auto* reference = std::get_if<ReferenceTelegram>(&telegram);
  // Also before this slave takes part: its first answer keeps the slots.
  if (reference != nullptr) process_data_ = true;
  if (!is_synchronous(state_)) return std::nullopt;
  const std::optional<can::Frame> frame = answer(telegram);
  if (!frame) return std::nullopt;
  const AnswerSlot slot = reference != nullptr ? actual_slot(reference->channel) : AnswerSlot::response;
  if (slot == AnswerSlot::response) ++responses_.asked;
  return SlaveAnswer{
      *frame, slot,
      start_window(slot, process_data_ || had_process_data_, slot_times(settings_.bit_rate), since_sync)};
}

bool Slave::may_start(const SlaveAnswer& answer, Duration since_sync) noexcept {
  const bool response = answer.slot == AnswerSlot::response;
  const unsigned channel = index(answer.slot);
  if (since_sync > answer.window.latest) {
    if (response) {
      ++responses_.late;
    } else {
      ++counters_[channel].late;
      // Else it is of an interval before, and this one's release waits still.
      if (release_[channel] == ActualRelease::built) release_[channel] = ActualRelease::late;
    }
    return false;
  }
  if (!response && handed_[channel]) ++counters_[channel].lost;
  handed_[channel] = {answer.frame, interval_};
  return true;
}

void Slave::sent(const can::Frame& answer) noexcept {
  for (const AnswerSlot slot : {AnswerSlot::actual_one, AnswerSlot::actual_two}) {
    auto& handed = handed_[index(slot)];
    if (!handed || handed->frame != answer) continue;
    if (handed->interval == interval_) release_[index(slot)] = ActualRelease::sent;
    handed.reset();
    ++counters_[index(slot)].sent;
    return;
  }
  auto& response = handed_[index(AnswerSlot::response)];
  if (!response || response->frame != answer) return;
  response.reset();
  ++responses_.sent;
  const Answered kind = std::exchange(answered_kind_, Answered::none);
  if (kind == Answered::parameter) {
    written_.reset();
    application_.parameter_answered();
  }
  if (kind == Answered::transfer) transfers_.answered();
}

std::optional<can::Frame> Slave::answer(const Telegram& telegram) noexcept {
  // The telegrams of every interval are looked at first.
  if (const auto* reference = std::get_if<ReferenceTelegram>(&telegram)) return answer(*reference);
  if (const auto* actual = std::get_if<ActualTelegram>(&telegram)) {
    take(*actual);
  } else if (const auto* action = std::get_if<ActionCommand>(&telegram)) {
    take(*action);
  } else if (const auto* parameter = std::get_if<ParameterCommand>(&telegram)) {
    return answer(*parameter);
  } else if (const auto* initialise = std::get_if<TransferInitialise>(&telegram)) {
    return serve_transfer(*initialise);
  } else if (const auto* upload = std::get_if<UploadBlock>(&telegram)) {
    return serve_transfer(*upload);
  } else if (const auto* download = std::get_if<DownloadBlock>(&telegram)) {
    return serve_transfer(*download);
  }
  return std::nullopt;
}

std::optional<can::Frame> Slave::answer(const ReferenceTelegram& telegram) noexcept {
  if (!is_active(state_)) return std::nullopt;
  const unsigned channel = index(telegram.channel);
  if (telegram.words > 0) {
    const std::size_t words = telegram.words < kWords ? telegram.words : kWords;
    references_of_[channel](std::span(telegram.word).first(words), references_);
    fresh_[channel] = true;
  }
  if (telegram.polled != settings_.number.value()) return std::nullopt;
  ++counters_[channel].asked;
  if (release_[channel] != ActualRelease::released) {
    ++counters_[channel].not_released;
    return std::nullopt;
  }
  release_[channel] = ActualRelease::built;
  const TelegramMapping& mapping = settings_.actual_mapping[channel];
  ActualTelegram reply;
  reply.channel = telegram.channel;
  reply.slave = settings_.number;
  reply.words = settings_.full_length ? static_cast<std::uint8_t>(kWords) : mapping.used_words();
  reply.word = pack(mapping, actual_);
  return encode(reply);
}

std::optional<can::Frame> Slave::answer(const ParameterCommand& command) noexcept {
  if (command.slave != settings_.number) return std::nullopt;
  if (written_ == command && application_.keeps_answer()) {
    note_answer(false, Answered::parameter);
    return written_answer_;
  }
  written_.reset();
  if (pending_ && *pending_ != command) application_.parameter_dropped();
  pending_.reset();
  ParameterAnswer answer;
  Answered by = Answered::parameter;
  if (command.kind == ParameterCommand::Kind::read) {
    answer = application_.read_parameter(command.number, command.element, command.sub_slave);
  } else if (command.element != kValueElement) {
    answer.error = ParameterError::not_changeable;
    by = Answered::none;
  } else {
    const bool doubleword = command.kind == ParameterCommand::Kind::write_doubleword;
    answer = application_.write_parameter(command.number, command.element, command.sub_slave, doubleword,
                                          command.value);
  }
  if (answer.busy) pending_ = command;
  note_answer(answer.busy, by);
  const can::Frame frame = encode(reply_to(command, answer));
  if (command.kind != ParameterCommand::Kind::read && !answer.busy && by == Answered::parameter) {
    written_ = command;
    written_answer_ = frame;
  }
  return frame;
}

template <class Command>
std::optional<can::Frame> Slave::serve_transfer(const Command& command) noexcept {
  if (command.slave != settings_.number) return std::nullopt;
  const TransferServer::Answer answer = transfers_.serve(command);
  note_answer(answer.busy, Answered::transfer);
  return answer.frame;
}

/// A busy answer needs no word when it was on the bus; a newer answer replaces one that was not.
void Slave::note_answer(bool busy, Answered kind) noexcept {
  if (busy) ++responses_.busy;
  answered_kind_ = busy ? Answered::none : kind;
  handed_[index(AnswerSlot::response)].reset();
}

void Slave::take(const ActionCommand& action) noexcept {
  if (!action.slaves.has(settings_.number)) return;
  if (action.command == settings_.activate_command) sync_mode_ = action.data_byte;
  if (action.command == kCommandControlWord) {
    application_.control_word(action.data_word);
  } else if (action.command == settings_.activate_command && action.data_byte == settings_.activate_data) {
    sync_activated_ = true;
    application_.sync_activated();
  } else {
    application_.action(action.command, action.data_byte, action.data_word);
  }
}

void Slave::take(const ActualTelegram& telegram) noexcept {
  const auto& mapping = settings_.monitored[telegram.slave.value()];
  if (!mapping || !is_active(state_) || telegram.words == 0) return;
  const unsigned channel = index(telegram.channel);
  const std::size_t words = telegram.words < kWords ? telegram.words : kWords;
  unpack((*mapping)[channel], std::span(telegram.word).first(words), monitored_[telegram.slave.value()]);
  ++monitored_count_[telegram.slave.value()][channel];
  monitored_interval_[telegram.slave.value()][channel] = interval_;
  heard_[channel] = telegram.slave;
}

}  // namespace cansync
