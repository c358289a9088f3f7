#include "cansync/slave/block_area.h"

#include <algorithm>
#include <utility>

namespace cansync {
namespace {

/// Start addresses below are jobs of the operating system (M 3.2.3.7).
constexpr std::uint32_t kFirstAddress = 0x100;
/// Codes below are the module's own (M 3.2.3.7).
constexpr std::uint16_t kFirstApplicationError = 0x0100;

}  // namespace

// --- of the slave

BlockArea::BlockAnswer BlockArea::begin(const TransferInitialise& initialise) noexcept {
  switch (phase_) {
    case Phase::asked:
      return BlockAnswer::later();
    case Phase::allowed: {
      phase_ = Phase::moving;
      BlockAnswer answer;
      if (length_ != block_.length) answer.length = length_;
      return answer;
    }
    case Phase::ended:
      phase_ = Phase::none;
      return failure();
    default:
      break;
  }
  sent();  // the master has gone on, so it has the answer to the block before
  if (initialise.address < kFirstAddress) return BlockAnswer::refused(TransferError::address_not_allowed);
  if (initialise.sub_slave.value != 0 || !application_)
    return BlockAnswer::refused(TransferError::not_possible);
  block_ = {++ids_, initialise.direction, initialise.address, initialise.length.value(),
            settings_.area && initialise.length.value() <= kBlockAreaBytes};
  phase_ = Phase::asked;
  length_ = 0;
  counter_ = 0;
  progress();
  listener_.block_begun(block_);
  return BlockAnswer::later();
}

BlockArea::BlockAnswer BlockArea::read(std::uint16_t offset, std::span<std::uint8_t> out) noexcept {
  if (phase_ == Phase::ended) return failure();
  if (!block_.area) {
    const auto size = static_cast<std::uint8_t>(std::min(out.size(), step_.data.size()));
    if (phase_ != Phase::answered) return ask_step({offset, size, {}});
    std::copy_n(step_.data.begin(), size, out.begin());
    phase_ = Phase::moving;
  } else {
    if (offset + out.size() > area_.size()) return BlockAnswer::refused(TransferError::not_possible);
    std::copy_n(area_.begin() + offset, out.size(), out.begin());
  }
  counter_ = static_cast<std::uint16_t>(offset + out.size());
  progress();
  return {};
}

BlockArea::BlockAnswer BlockArea::write(std::uint16_t offset, std::span<const std::uint8_t> data) noexcept {
  if (phase_ == Phase::ended) return failure();
  if (phase_ == Phase::waiting) return BlockAnswer::later();
  if (phase_ == Phase::answered) {
    phase_ = Phase::moving;
    counter_ = static_cast<std::uint16_t>(offset + data.size());
    progress();
    return {};
  }
  if (!block_.area) {
    AskedStep asked{offset, static_cast<std::uint8_t>(std::min(data.size(), step_.data.size())), {}};
    std::copy_n(data.begin(), asked.bytes, asked.data.begin());
    return ask_step(asked);
  }
  if (offset + data.size() > length_ || length_ > area_.size())
    return BlockAnswer::refused(TransferError::not_possible);
  std::copy(data.begin(), data.end(), area_.begin() + offset);
  counter_ = static_cast<std::uint16_t>(offset + data.size());
  progress();
  if (counter_ < length_) return {};
  phase_ = Phase::waiting;
  listener_.block_complete(block_.id);
  return BlockAnswer::later();
}

BlockArea::BlockAnswer BlockArea::ask_step(const AskedStep& step) noexcept {
  if (phase_ == Phase::moving) {
    step_ = step;
    phase_ = Phase::waiting;
    listener_.step_asked(block_.id, step_);
  }
  return BlockAnswer::later();
}

void BlockArea::end(bool complete) noexcept {
  const bool open = phase_ != Phase::none && phase_ != Phase::ended;
  const std::uint64_t id = std::exchange(block_.id, 0);
  phase_ = Phase::none;
  if (complete) {
    sending_ = id;
  } else if (open) {
    listener_.block_ended(id, BlockEnd::cancelled);
  }
}

void BlockArea::sent() noexcept {
  end_sending(BlockEnd::done);
}

void BlockArea::dropped() noexcept {
  end_sending(BlockEnd::cancelled);
}

void BlockArea::end_sending(BlockEnd end) noexcept {
  if (const std::uint64_t id = std::exchange(sending_, 0); id != 0) listener_.block_ended(id, end);
}

void BlockArea::at(Duration now) noexcept {
  now_ = now;
  if (settings_.monitoring.count() == 0 || now - moved_ <= settings_.monitoring) return;
  if (block_.id != 0) fail(TransferError::cancelled_by_slave, BlockEnd::timed_out);
  end_sending(BlockEnd::timed_out);
}

void BlockArea::fail(TransferError error, BlockEnd end) noexcept {
  error_ = error;
  phase_ = Phase::ended;
  listener_.block_ended(std::exchange(block_.id, 0), end);
}

BlockArea::BlockAnswer BlockArea::failure() const noexcept {
  return BlockAnswer::refused(error_);
}

// --- of the application

void BlockArea::set_application(bool present) noexcept {
  application_ = present;
  if (!present && block_.id != 0) fail(TransferError::cancelled_by_slave, BlockEnd::application);
}

bool BlockArea::allow(std::uint64_t id, std::span<const std::uint8_t> upload, std::uint16_t length) noexcept {
  if (!waits_for(id) || phase_ != Phase::asked) return false;
  std::size_t bytes = block_.length;
  if (block_.direction == AskedBlock::Direction::upload) {
    if (block_.area) {
      bytes = upload.size();
      if (bytes > area_.size()) return false;
    } else if (length != 0) {
      bytes = length;
    }
    if (bytes == 0 || bytes > BlockOffset::max) return false;
    if (block_.area) std::copy(upload.begin(), upload.end(), area_.begin());
  }
  length_ = static_cast<std::uint16_t>(bytes);
  phase_ = Phase::allowed;
  progress();
  return true;
}

bool BlockArea::refuse(std::uint64_t id, TransferError error) noexcept {
  if (!waits_for(id)) return false;
  const bool allowed = static_cast<std::uint16_t>(error) >= kFirstApplicationError;
  fail(allowed ? error : TransferError::not_possible, BlockEnd::refused);
  return true;
}

bool BlockArea::take(std::uint64_t id) noexcept {
  if (!waits_for(id) || phase_ != Phase::waiting || !block_.area) return false;
  phase_ = Phase::answered;
  progress();
  return true;
}

bool BlockArea::step(std::uint64_t id, std::span<const std::uint8_t> upload) noexcept {
  if (!waits_for(id) || phase_ != Phase::waiting || block_.area) return false;
  if (block_.direction == AskedBlock::Direction::upload) {
    if (upload.size() != step_.bytes) return false;
    std::copy(upload.begin(), upload.end(), step_.data.begin());
  }
  phase_ = Phase::answered;
  progress();
  return true;
}

}  // namespace cansync
