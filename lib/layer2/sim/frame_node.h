#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "can/bus.h"
#include "can/frame.h"
#include "sim/node.h"

namespace sim {

/// What a simulated node of layer 2 does.
struct FrameNodeSettings {
  NodeNumber number = 0;  ///< by which faults and traces name it, 0..31
  /// Data frames, each sent as the answer to a remote frame of its identifier and width.
  std::vector<can::Frame> answers;
  can::Time answer_time = std::chrono::microseconds(100);  ///< from the remote frame's end to the answer
  std::optional<can::Frame> periodic;  ///< sent again and again; nothing: the node only answers
  can::Time period = std::chrono::milliseconds(100);  ///< from the end of one to the next being ready, over 0
};

/// A node that knows no protocol: it answers remote frames, and sends one frame again and again. The first
/// byte of the periodic frame, when it has data, counts up with each frame.
class FrameNode final : public Node {
 public:
  explicit FrameNode(FrameNodeSettings settings) : settings_(std::move(settings)) {}

  NodeNumber node_number() const noexcept override { return settings_.number; }
  bool accepts(const can::Frame& frame) const noexcept override { return frame.remote; }
  void on_sync(can::Time) noexcept override {}
  std::optional<Transmission> on_frame(const can::Frame& frame, can::Time end) noexcept override;
  std::optional<Transmission> on_join(can::Time now) noexcept override;
  std::optional<Transmission> on_sent(const can::Frame& frame, can::Time end) noexcept override;

 private:
  FrameNodeSettings settings_;
};

}  // namespace sim
