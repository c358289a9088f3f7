#include <algorithm>

#include "cansync/slave/slave.h"
#include "cansync/telegram/reply_payload.h"

// The slave's uploads and downloads (M 3.2.1.3, "Start of an upload or download" and following).
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

}  // namespace

template <class Command>
std::optional<can::Frame> Slave::serve_transfer(const Command& command) noexcept {
  if (command.slave != settings_.number) return std::nullopt;
  if (answered_) {
    const auto* before = std::get_if<Command>(&*answered_);
    if (before != nullptr && *before == command) return last_answer_;
  }
  const TransferReply reply = answer(command);
  const can::Frame frame = encode(reply);
  if (!reply.busy && !reply.error) {
    answered_.emplace(command);
    last_answer_ = frame;
  }
  return frame;
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

}  // namespace cansync
