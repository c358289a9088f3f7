#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "cansync/slave/slave.h"

namespace sim {

/// First start address that is not reserved for the slave's operating system (M 4.24).
inline constexpr std::uint32_t kFirstAddress = 0x100;

/// Settings of a drive's memory for uploads and downloads.
struct MemorySettings {
  std::uint32_t size = 1024 * 1024;  ///< bytes; the first lies at address 0x100
  std::uint8_t address_step = 1;     ///< bytes per start address: 1, or 4 if addresses count doublewords
  std::uint16_t upload_length = 0;   ///< bytes per block that the drive fixes for uploads; 0 = as asked
  std::uint32_t busy_replies = 0;    ///< how often each telegram of a transfer is answered busy first
};

/// Memory of a drive that uploads read and downloads write. All memory is taken in the constructor; nothing
/// else allocates, blocks or throws. Not thread safe.
class DriveMemory {
 public:
  using BlockAnswer = cansync::SlaveApplication::BlockAnswer;

  /// Filled with zeros. An `address_step` of 0 counts as 1.
  explicit DriveMemory(const MemorySettings& settings);

  /// Begins a block: `address_not_allowed` for a reserved address, a sub-slave, or a start beyond the end;
  /// `block_too_long` when it reaches beyond the end.
  BlockAnswer begin(const cansync::TransferInitialise& initialise) noexcept;
  BlockAnswer read(std::uint16_t offset, std::span<std::uint8_t> out) noexcept;
  BlockAnswer write(std::uint16_t offset, std::span<const std::uint8_t> data) noexcept;
  void end(bool complete) noexcept;

  /// The bytes from start address 0x100 on.
  std::span<std::uint8_t> contents() noexcept { return bytes_; }
  std::span<const std::uint8_t> contents() const noexcept { return bytes_; }

  /// Blocks that were completed, and that were cancelled, since the construction.
  std::uint64_t completed() const noexcept { return completed_; }
  std::uint64_t cancelled() const noexcept { return cancelled_; }

  void set_upload_length(std::uint16_t bytes) noexcept { settings_.upload_length = bytes; }
  void set_busy_replies(std::uint32_t replies) noexcept { settings_.busy_replies = replies; }

 private:
  bool still_busy() noexcept;

  MemorySettings settings_;
  std::vector<std::uint8_t> bytes_;
  std::size_t start_ = 0;  ///< of the block begun last, in `bytes_`
  std::uint32_t busy_given_ = 0;
  std::uint64_t completed_ = 0;
  std::uint64_t cancelled_ = 0;
};

}  // namespace sim
