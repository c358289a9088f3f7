#include "cansync/slave/transfer_server.h"

#include <algorithm>
#include <array>
#include <span>
#include <type_traits>
#include <utility>
#include <variant>

#include "cansync/telegram/reply_payload.h"

namespace cansync {
namespace {

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

template <class Command>
TransferServer::Answer TransferServer::serve(const Command& command) noexcept {
  if (is_answered(command)) return {last_answer_};
  // With a new block the master has gone on, so that it has the answer.
  if (!begins_block(command)) drop_last_answer();
  ending_ = false;
  const TransferReply reply = answer(command);
  const can::Frame frame = encode(reply);
  if (!reply.busy && !reply.error) {
    answered_.emplace(command);
    last_answer_ = frame;
  }
  return {frame, reply.busy};
}

/// The answer that it got still stands.
template <class Command>
bool TransferServer::is_answered(const Command& command) noexcept {
  if (!answered_) return false;
  const auto* before = std::get_if<Command>(&*answered_);
  if (before == nullptr || *before != command) return false;
  if constexpr (std::is_same_v<Command, TransferInitialise>) {
    if (open() && !application_.block_open()) {
      enter(BlockEvent::over);
      answered_.reset();
      return false;
    }
  }
  return true;
}

template TransferServer::Answer TransferServer::serve(const TransferInitialise&) noexcept;
template TransferServer::Answer TransferServer::serve(const UploadBlock&) noexcept;
template TransferServer::Answer TransferServer::serve(const DownloadBlock&) noexcept;

TransferReply TransferServer::answer(const TransferInitialise& initialise) noexcept {
  const bool asked_again = block_.phase == BlockPhase::beginning && block_.initialise == initialise;
  if (!asked_again) drop();
  TransferReply reply;
  reply.slave = number_;
  if (is_cancel(initialise)) return reply;
  if (const TransferError error = check_length(initialise); error != TransferError::none) {
    return refuse({}, error);
  }
  const BlockAnswer begun = application_.begin_block(initialise);
  if (begun.busy || begun.error != TransferError::none) {
    enter(begun.busy ? BlockEvent::later : BlockEvent::ended);
    block_.initialise = initialise;
    if (!begun.busy) return refuse({}, begun.error);
    put_busy(reply);
    return reply;
  }
  const bool fixed = initialise.direction == Direction::upload && begun.length != 0;
  const std::optional<BlockOffset> fixed_length = BlockOffset::from(fixed ? begun.length : 0);
  const std::uint16_t length = fixed ? begun.length : initialise.length.value();
  enter(BlockEvent::begun);
  block_.initialise = initialise;
  block_.length = length;
  block_.expected = 0;
  if (!fixed_length || length == 0) {
    drop();
    return refuse({}, TransferError::not_possible);
  }
  reply.offset = *fixed_length;
  return reply;
}

TransferReply TransferServer::answer(const UploadBlock& block) noexcept {
  if (const TransferError error = check_order(Direction::upload, block.offset, block.last);
      error != TransferError::none) {
    return refuse(block.offset, error);
  }
  std::array<std::uint8_t, kTransferBytes> data = {};
  const BlockAnswer read = application_.read_block(block_.expected, std::span(data).first(bytes_due()));
  TransferReply reply = block_done(block.offset, block.last, read);
  if (!reply.busy && !reply.error) {
    // Always six bytes; what the block does not have is padded with zeros.
    put_upload(reply, data);
  }
  return reply;
}

TransferReply TransferServer::answer(const DownloadBlock& block) noexcept {
  if (const TransferError error = check_order(Direction::download, block.offset, block.last);
      error != TransferError::none) {
    return refuse(block.offset, error);
  }
  const BlockAnswer written =
      application_.write_block(block_.expected, std::span(block.data).first(bytes_due()));
  return block_done(block.offset, block.last, written);
}

TransferReply TransferServer::block_done(BlockOffset offset, bool last, const BlockAnswer& answer) noexcept {
  TransferReply reply;
  reply.slave = number_;
  reply.offset = offset;
  if (answer.busy) {
    put_busy(reply);
    return reply;
  }
  if (answer.error != TransferError::none) {
    if (answer.error == TransferError::cancelled_by_slave) drop();
    return refuse(offset, answer.error);
  }
  block_.expected = static_cast<std::uint16_t>(block_.expected + kTransferBytes);
  if (last) {
    enter(BlockEvent::ended);
    application_.end_block(true);
    ending_ = true;
  }
  return reply;
}

TransferError TransferServer::check_length(const TransferInitialise& initialise) const noexcept {
  const std::uint16_t length = initialise.length.value();
  if (length > block_limit_) {
    return block_limit_ == kModuleBlockLimit ? TransferError::longer_than_300_bytes
                                             : TransferError::block_too_long;
  }
  // An upload may leave the length to the slave.
  if (length == 0 && initialise.direction == Direction::download) return TransferError::not_possible;
  return TransferError::none;
}

TransferError TransferServer::check_order(Direction direction, BlockOffset offset, bool last) const noexcept {
  if (!open() || block_.initialise.direction != direction) return TransferError::mode_not_allowed;
  if (offset.value() != block_.expected) return TransferError::other_block_expected;
  const bool is_last = block_.expected + kTransferBytes >= block_.length;
  if (last && !is_last) return TransferError::end_not_expected;
  if (!last && is_last) return TransferError::end_expected;
  return TransferError::none;
}

std::size_t TransferServer::bytes_due() const noexcept {
  return std::min<std::size_t>(kTransferBytes, block_.length - block_.expected);
}

TransferReply TransferServer::refuse(BlockOffset offset, TransferError error) const noexcept {
  TransferReply reply;
  reply.slave = number_;
  put_error(reply, error);
  // "The slave expects the block that the counter names" (M 3.2.2.6): the reply's offset is that counter.
  reply.offset = error == TransferError::other_block_expected
                     ? BlockOffset::from(block_.expected).value_or(offset)
                     : offset;
  return reply;
}

void TransferServer::drop() noexcept {
  const bool begun = block_.phase != BlockPhase::none;
  enter(BlockEvent::ended);
  // The same telegram begins a block anew after this.
  answered_.reset();
  if (begun) application_.end_block(false);
}

void TransferServer::stop() noexcept {
  drop();
  drop_last_answer();
}

void TransferServer::answered() noexcept {
  ending_ = false;
  application_.transfer_answered();
}

void TransferServer::enter(BlockEvent event) noexcept {
  block_.phase = next(block_.phase, event).value_or(block_.phase);
}

void TransferServer::drop_last_answer() noexcept {
  if (std::exchange(ending_, false)) application_.transfer_dropped();
}

}  // namespace cansync
