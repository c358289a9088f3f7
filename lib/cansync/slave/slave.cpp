#include "cansync/slave/slave.h"

#include "cansync/telegram/reply_payload.h"

namespace cansync {
namespace {

constexpr std::uint8_t kFirstUserCommand = 128;

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
    : settings_(settings), application_(application) {}

bool Slave::control(ControlCommand command) noexcept {
  const std::optional<State> to = next(Role::slave, state_, command);
  if (!to) return false;
  state_ = *to;
  if (!is_synchronous(state_)) {
    drop_transfer();
    if (pending_) application_.parameter_dropped();
    pending_.reset();
    sync_activated_ = false;
  }
  if (!is_active(state_)) on_sync();
  return true;
}

std::optional<can::Frame> Slave::receive(const can::Frame& frame) noexcept {
  const Decoded decoded = decode(frame);
  const auto* telegram = std::get_if<Telegram>(&decoded);
  if (telegram == nullptr) return std::nullopt;
  return receive(*telegram);
}

std::optional<can::Frame> Slave::receive(const Telegram& telegram) noexcept {
  if (!is_synchronous(state_)) return std::nullopt;
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
    unpack(settings_.reference_mapping[channel], std::span(telegram.word).first(words), references_);
    fresh_[channel] = true;
  }
  if (telegram.polled != settings_.number.value() || !released_[channel]) return std::nullopt;
  released_[channel] = false;
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
  if (pending_ && *pending_ != command) application_.parameter_dropped();
  pending_.reset();
  ParameterAnswer answer;
  if (command.kind == ParameterCommand::Kind::read) {
    answer = application_.read_parameter(command.number, command.element, command.sub_slave);
  } else if (command.element != kValueElement) {
    answer.error = ParameterError::not_changeable;
  } else {
    const bool doubleword = command.kind == ParameterCommand::Kind::write_doubleword;
    answer = application_.write_parameter(command.number, command.element, command.sub_slave, doubleword,
                                          command.value);
  }
  if (answer.busy) pending_ = command;
  return encode(reply_to(command, answer));
}

void Slave::take(const ActionCommand& action) noexcept {
  if (!action.slaves.has(settings_.number)) return;
  if (action.command == kCommandControlWord) {
    application_.control_word(action.data_word);
  } else if (action.command == settings_.activate_command) {
    if (action.data_byte != settings_.activate_data) return;
    sync_activated_ = true;
    application_.sync_activated();
  } else if (action.command >= kFirstUserCommand) {
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
}

}  // namespace cansync
