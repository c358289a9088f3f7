#include "layer2/sim/frame_node.h"

namespace sim {

std::optional<Transmission> FrameNode::on_frame(const can::Frame& frame, can::Time end) noexcept {
  if (!frame.remote) return std::nullopt;
  for (const can::Frame& answer : settings_.answers) {
    if (answer.extended == frame.extended && answer.identifier() == frame.identifier())
      return Transmission{answer, end + settings_.answer_time};
  }
  return std::nullopt;
}

std::optional<Transmission> FrameNode::on_join(can::Time now) noexcept {
  if (!settings_.periodic) return std::nullopt;
  return Transmission{*settings_.periodic, now + settings_.period};
}

std::optional<Transmission> FrameNode::on_sent(const can::Frame& frame, can::Time end) noexcept {
  if (!settings_.periodic || frame != *settings_.periodic) return std::nullopt;
  can::Frame& next = *settings_.periodic;
  if (!next.remote && next.dlc != 0) ++next.data[0];
  return Transmission{next, end + settings_.period};
}

}  // namespace sim
