#pragma once

#include <cansync/function_blocks/types.h>

#include <cstddef>
#include <cstdint>
#include <span>

/// The table in a data block (Saia 4.2.2, 4.2.4): a header of four words, then entries; high bytes first.
/// Internal to the function blocks.
namespace cansync::client::function_blocks {

/// Entries of `size` bytes each; `bytes` must outlive it.
class BlockTable {
 public:
  static constexpr std::size_t kHeader = 8;

  BlockTable(std::span<const std::uint8_t> bytes, std::size_t size) noexcept : bytes_(bytes), size_(size) {}

  /// DBVersion is 0.
  bool known() const noexcept { return bytes_.size() >= kHeader && bytes_[0] == 0 && bytes_[1] == 0; }
  /// Whole entries.
  std::size_t count() const noexcept { return known() ? (bytes_.size() - kHeader) / size_ : 0; }
  /// A number at `offset` of an entry, both of which must be there.
  std::uint8_t byte(std::size_t entry, std::size_t offset) const noexcept {
    return bytes_[kHeader + entry * size_ + offset];
  }
  INT word(std::size_t entry, std::size_t offset) const noexcept {
    return static_cast<INT>(byte(entry, offset) << 8 | byte(entry, offset + 1));
  }
  DWORD double_word(std::size_t entry, std::size_t offset) const noexcept {
    return DWORD{static_cast<WORD>(word(entry, offset))} << 16 | static_cast<WORD>(word(entry, offset + 2));
  }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t size_;
};

}  // namespace cansync::client::function_blocks
