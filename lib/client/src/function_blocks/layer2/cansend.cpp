#include <cansync/function_blocks/layer2/cansend.h>
#include <cansync/function_blocks/module_codes.h>
#include <fmt/format.h>

#include <utility>

#include "client/src/function_blocks/layer2/module_frame.h"
#include "client/src/layer2/frame_side.h"

namespace cansync::client::function_blocks {

void CANSEND::call() {
  detail::FrameSide& side = connection_->side();
  side.look();
  RETVAL = Snd ? send() : module_code::done;
  if (RETVAL == module_code::done) Snd = false;
  side.look();
  if (RETVAL == module_code::done) error_ = side.failure();
  STAT = side.status_word();
}

UDINT CANSEND::failures() const noexcept {
  return connection_->side().failures();
}

INT CANSEND::send() {
  detail::FrameSide& side = connection_->side();
  can::Frame frame;
  frame.extended = width_ == IdentifierWidth::bits_29;
  frame.id = std::uint32_t{IDHI} << 16 | IDLO;
  frame.remote = (RTRLEN & kRemoteBit) != 0;
  frame.dlc = static_cast<std::uint8_t>(RTRLEN & kLengthBits);
  if (frame.id != frame.identifier())
    return refuse(module_code::input_invalid,
                  fmt::format("client: IDHI, IDLO 0x{:X}: out of range; allowed 0..0x{:X}", frame.id,
                              frame.extended ? can::kExtendedIdentifierMask : can::kStandardIdentifierMask));
  if (frame.dlc > 8)
    return refuse(module_code::input_invalid,
                  fmt::format("client: RTRLEN: length {}: out of range; allowed 0..8", frame.dlc));
  if (!frame.remote) frame.data = bytes_of({DW0, DW1, DW2, DW3}, frame.dlc);
  if (side.take_restart())
    return refuse(
        module_code::not_ready,
        "client: the daemon was started anew: this frame was not sent; call again if it still holds");
  if (std::string obstacle = side.obstacle(); !obstacle.empty())
    return refuse(module_code::not_ready, std::move(obstacle));
  side.queues().send(frame, (RTRLEN & kHighPriorityBit) != 0);
  return module_code::done;
}

INT CANSEND::refuse(INT code, std::string reason) {
  error_ = std::move(reason);
  return code;
}

}  // namespace cansync::client::function_blocks
