#include "cansync/sim/drive_memory.h"

#include <algorithm>

namespace sim {

using cansync::TransferError;
using Direction = cansync::TransferInitialise::Direction;

DriveMemory::DriveMemory(const MemorySettings& settings) : settings_(settings), bytes_(settings.size) {
  settings_.address_step = std::max<std::uint8_t>(settings_.address_step, 1);
}

bool DriveMemory::still_busy() noexcept {
  if (busy_given_ >= settings_.busy_replies) {
    busy_given_ = 0;
    return false;
  }
  ++busy_given_;
  return true;
}

DriveMemory::BlockAnswer DriveMemory::begin(const cansync::TransferInitialise& initialise) noexcept {
  BlockAnswer answer;
  // A drive has no sub-slaves.
  if (initialise.address < kFirstAddress || initialise.sub_slave.value != 0) {
    answer.error = TransferError::address_not_allowed;
    return answer;
  }
  const std::uint64_t start = std::uint64_t{initialise.address - kFirstAddress} * settings_.address_step;
  const bool fixed = initialise.direction == Direction::upload && settings_.upload_length != 0;
  const std::uint64_t length = fixed ? settings_.upload_length : initialise.length.value();
  if (start >= bytes_.size()) {
    answer.error = TransferError::address_not_allowed;
  } else if (start + length > bytes_.size()) {
    answer.error = TransferError::block_too_long;
  } else if (still_busy()) {
    answer.busy = true;
  } else {
    start_ = static_cast<std::size_t>(start);
    answer.length = fixed ? settings_.upload_length : std::uint16_t{0};
  }
  return answer;
}

// The slave keeps offset and length within the block that `begin` has checked; the comparisons hold even a
// wrong caller inside the memory.
DriveMemory::BlockAnswer DriveMemory::read(std::uint16_t offset, std::span<std::uint8_t> out) noexcept {
  BlockAnswer answer;
  answer.busy = still_busy();
  if (answer.busy) return answer;
  if (start_ + offset + out.size() > bytes_.size()) {
    answer.error = TransferError::not_possible;
    return answer;
  }
  std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(start_ + offset), out.size(), out.begin());
  return answer;
}

DriveMemory::BlockAnswer DriveMemory::write(std::uint16_t offset,
                                            std::span<const std::uint8_t> data) noexcept {
  BlockAnswer answer;
  answer.busy = still_busy();
  if (answer.busy) return answer;
  if (start_ + offset + data.size() > bytes_.size()) {
    answer.error = TransferError::not_possible;
    return answer;
  }
  std::copy(data.begin(), data.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(start_ + offset));
  return answer;
}

void DriveMemory::end(bool complete) noexcept {
  busy_given_ = 0;
  ++(complete ? completed_ : cancelled_);
}

}  // namespace sim
