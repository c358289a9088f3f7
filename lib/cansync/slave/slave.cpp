#include "cansync/slave/slave.h"

#include <algorithm>
#include <type_traits>
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

using Direction = TransferInitialise::Direction;
using BlockAnswer = SlaveApplication::BlockAnswer;

/// Limit of the option modules, which has an error code of its own.
constexpr std::uint16_t kModuleBlockLimit = 300;

bool is_cancel(const TransferInitialise& initialise) noexcept {
  return initialise.direction == Direction::upload && initialise.length.value() == 0 &&
         initialise.address == 0;
}

bool begins_block(const TransferInitialise& initialise) noexcept {
  return !is_cancel(initialise);
}
template <class Command>
bool begins_block(const Command&) noexcept {
  return false;
}

}  // namespace

// --- uploads and downloads (M 3.2.1.3, "Start of an upload or download" and following)

template <class Command>
std::optional<can::Frame> Slave::serve_transfer(const Command& command) noexcept {
  if (command.slave != settings_.number) return std::nullopt;
  if (is_answered(command)) {
    note_answer(false, Answered::transfer);
    return last_answer_;
  }
  // With a new block the master has gone on, so that it has the answer.
  if (!begins_block(command)) drop_last_answer();
  ending_ = false;
  const TransferReply reply = answer(command);
  note_answer(reply.busy, Answered::transfer);
  const can::Frame frame = encode(reply);
  if (!reply.busy && !reply.error) {
    answered_.emplace(command);
    last_answer_ = frame;
  }
  return frame;
}

/// The answer that it got still stands.
template <class Command>
bool Slave::is_answered(const Command& command) noexcept {
  if (!answered_) return false;
  const auto* before = std::get_if<Command>(&*answered_);
  if (before == nullptr || *before != command) return false;
  if constexpr (std::is_same_v<Command, TransferInitialise>) {
    if (transfer_open() && !application_.block_open()) {
      transfer_.phase = OpenBlock::Phase::beginning;
      answered_.reset();
      return false;
    }
  }
  return true;
}

template std::optional<can::Frame> Slave::serve_transfer(const TransferInitialise&) noexcept;
template std::optional<can::Frame> Slave::serve_transfer(const UploadBlock&) noexcept;
template std::optional<can::Frame> Slave::serve_transfer(const DownloadBlock&) noexcept;

TransferReply Slave::answer(const TransferInitialise& initialise) noexcept {
  const bool asked_again =
      transfer_.phase == OpenBlock::Phase::beginning && transfer_.initialise == initialise;
  if (!asked_again) drop_transfer();
  TransferReply reply;
  reply.slave = settings_.number;
  if (is_cancel(initialise)) return reply;
  if (const TransferError error = check_length(initialise); error != TransferError::none) {
    return refuse({}, error);
  }
  const BlockAnswer begun = application_.begin_block(initialise);
  if (begun.busy || begun.error != TransferError::none) {
    transfer_.phase = begun.busy ? OpenBlock::Phase::beginning : OpenBlock::Phase::none;
    transfer_.initialise = initialise;
    if (!begun.busy) return refuse({}, begun.error);
    put_busy(reply);
    return reply;
  }
  const bool fixed = initialise.direction == Direction::upload && begun.length != 0;
  const std::optional<BlockOffset> fixed_length = BlockOffset::from(fixed ? begun.length : 0);
  const std::uint16_t length = fixed ? begun.length : initialise.length.value();
  transfer_ = {OpenBlock::Phase::open, initialise, length, 0};
  if (!fixed_length || length == 0) {
    drop_transfer();
    return refuse({}, TransferError::not_possible);
  }
  reply.offset = *fixed_length;
  return reply;
}

TransferReply Slave::answer(const UploadBlock& block) noexcept {
  if (const TransferError error = check_order(Direction::upload, block.offset, block.last);
      error != TransferError::none) {
    return refuse(block.offset, error);
  }
  std::array<std::uint8_t, kTransferBytes> data = {};
  const BlockAnswer read = application_.read_block(transfer_.expected, std::span(data).first(bytes_due()));
  TransferReply reply = block_done(block.offset, block.last, read);
  if (!reply.busy && !reply.error) {
    // Always six bytes; what the block does not have is padded with zeros.
    put_upload(reply, data);
  }
  return reply;
}

TransferReply Slave::answer(const DownloadBlock& block) noexcept {
  if (const TransferError error = check_order(Direction::download, block.offset, block.last);
      error != TransferError::none) {
    return refuse(block.offset, error);
  }
  const BlockAnswer written =
      application_.write_block(transfer_.expected, std::span(block.data).first(bytes_due()));
  return block_done(block.offset, block.last, written);
}

TransferReply Slave::block_done(BlockOffset offset, bool last, const BlockAnswer& answer) noexcept {
  TransferReply reply;
  reply.slave = settings_.number;
  reply.offset = offset;
  if (answer.busy) {
    put_busy(reply);
    return reply;
  }
  if (answer.error != TransferError::none) {
    if (answer.error == TransferError::cancelled_by_slave) drop_transfer();
    return refuse(offset, answer.error);
  }
  transfer_.expected = static_cast<std::uint16_t>(transfer_.expected + kTransferBytes);
  if (last) {
    transfer_ = {};
    application_.end_block(true);
    ending_ = true;
  }
  return reply;
}

TransferError Slave::check_length(const TransferInitialise& initialise) const noexcept {
  const std::uint16_t length = initialise.length.value();
  if (length > settings_.block_limit) {
    return settings_.block_limit == kModuleBlockLimit ? TransferError::longer_than_300_bytes
                                                      : TransferError::block_too_long;
  }
  // An upload may leave the length to the slave.
  if (length == 0 && initialise.direction == Direction::download) return TransferError::not_possible;
  return TransferError::none;
}

TransferError Slave::check_order(Direction direction, BlockOffset offset, bool last) const noexcept {
  if (!transfer_open() || transfer_.initialise.direction != direction) return TransferError::mode_not_allowed;
  if (offset.value() != transfer_.expected) return TransferError::other_block_expected;
  const bool is_last = transfer_.expected + kTransferBytes >= transfer_.length;
  if (last && !is_last) return TransferError::end_not_expected;
  if (!last && is_last) return TransferError::end_expected;
  return TransferError::none;
}

std::size_t Slave::bytes_due() const noexcept {
  return std::min<std::size_t>(kTransferBytes, transfer_.length - transfer_.expected);
}

TransferReply Slave::refuse(BlockOffset offset, TransferError error) const noexcept {
  TransferReply reply;
  reply.slave = settings_.number;
  put_error(reply, error);
  // "The slave expects the block that the counter names" (M 3.2.2.6): the reply's offset is that counter.
  reply.offset = error == TransferError::other_block_expected
                     ? BlockOffset::from(transfer_.expected).value_or(offset)
                     : offset;
  return reply;
}

void Slave::drop_transfer() noexcept {
  const bool begun = transfer_.phase != OpenBlock::Phase::none;
  transfer_ = {};
  // The same telegram begins a block anew after this.
  answered_.reset();
  if (begun) application_.end_block(false);
}

void Slave::drop_last_answer() noexcept {
  if (std::exchange(ending_, false)) application_.transfer_dropped();
}

// --- everything else

Slave::Slave(const SlaveSideSettings& settings, SlaveApplication& application) noexcept
    : references_of_{Unpacking(settings.reference_mapping[0]), Unpacking(settings.reference_mapping[1])},
      settings_(settings),
      application_(application) {}

bool Slave::control(ControlCommand command) noexcept {
  const std::optional<State> to = next(Role::slave, state_, command);
  if (!to) return false;
  state_ = *to;
  if (!is_synchronous(state_)) {
    drop_transfer();
    drop_last_answer();
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
  if (kind != Answered::transfer) return;
  ending_ = false;
  application_.transfer_answered();
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
