#pragma once

#include <cstdint>

#include "bytes.h"
#include "can/frame.h"
#include "cansync/telegram/telegram.h"

namespace fuzz {

/// Number of the slave that the frames are for.
inline constexpr unsigned kNumber = 3;

/// Frames that a master may send, nearly: the identifier is one that this slave hears.
inline can::Frame heard(Bytes& in) {
  constexpr std::uint32_t kIdentifiers[] = {0x010, 0x100, 0x180, 0x17F, 0x300, 0x380, 0x500, 0x500};
  can::Frame frame;
  frame.id = kIdentifiers[in.below(8)];
  if ((frame.id & 0x7Fu) == 0) frame.id |= kNumber;
  frame.dlc = static_cast<std::uint8_t>(in.below(9));
  for (std::size_t i = 0; i < frame.dlc; ++i) frame.data[i] = in.byte();
  return frame;
}

/// A block from its beginning on, as a master moves it, which few inputs would reach.
class Transfer {
 public:
  void begin(Bytes& in) {
    upload_ = in.flag();
    length_ = static_cast<std::uint16_t>(in.below(64));
    offset_ = 0;
    begun_ = true;
  }
  cansync::Telegram next(Bytes& in) {
    using namespace cansync;
    const SlaveNumber slave = *SlaveNumber::from(kNumber);
    if (begun_) {
      begun_ = false;
      const auto direction =
          upload_ ? TransferInitialise::Direction::upload : TransferInitialise::Direction::download;
      return TransferInitialise{slave, direction, *BlockOffset::from(length_), 0x100, {}};
    }
    const BlockOffset offset = *BlockOffset::from(offset_);
    const bool last = offset_ + 6 >= length_;
    if (upload_) return UploadBlock{slave, offset, last};
    DownloadBlock block{slave, offset, last, {}};
    for (std::uint8_t& byte : block.data) byte = in.byte();
    return block;
  }
  void answered(const cansync::TransferReply& reply, bool beginning) {
    if (reply.busy || reply.error) return;
    if (beginning) {
      if (reply.offset.value() != 0) length_ = reply.offset.value();
    } else if (offset_ + 6 < length_) {
      offset_ = static_cast<std::uint16_t>(offset_ + 6);
    }
  }
  bool beginning() const noexcept { return begun_; }

 private:
  bool upload_ = false;
  bool begun_ = true;
  std::uint16_t length_ = 0;
  std::uint16_t offset_ = 0;
};

}  // namespace fuzz
