#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "can/bus.h"
#include "can/frame.h"
#include "sim/node.h"

namespace sim {

/// What a scripted device answers to a frame.
struct ScriptedAnswer {
  can::Frame to;                                      ///< its flags must be those of the frame
  std::uint32_t mask = can::kExtendedIdentifierMask;  ///< bits of the identifier that count
  std::array<std::uint8_t, 8> data_mask =
      {};            ///< bits of the data that count; a frame that is too short to have them does not fit
  can::Frame frame;  ///< the answer
  bool copy_data = false;            ///< the answer has the data of the frame it answers in place of its own
  can::Time after{};                 ///< from the end of the frame to the answer
  std::uint64_t count = UINT64_MAX;  ///< how often it answers at most
};

/// What a scripted device sends by itself.
struct ScriptedPeriod {
  can::Frame frame;
  can::Time every = std::chrono::milliseconds(100);  ///< between two, 100 us and more
  can::Time phase{};                                 ///< from the start to the first
  std::optional<std::uint8_t> counting;  ///< this byte of its data counts up with each; nothing: none
};

/// What a scripted device does.
struct DeviceSettings {
  NodeNumber number = 0;  ///< by which faults and traces name it, 0..31
  /// The first that fits answers, as long as its count lasts.
  std::vector<ScriptedAnswer> answers;
  std::vector<ScriptedPeriod> periods;
};

/// A device that does what a script says. What it should have sent while nobody asked it is left out, never
/// made up for.
class ScriptedDevice final : public Node {
 public:
  explicit ScriptedDevice(DeviceSettings settings);

  NodeNumber node_number() const noexcept override { return settings_.number; }
  bool accepts(const can::Frame& frame) const noexcept override;
  void on_sync(can::Time) noexcept override {}
  std::optional<Transmission> on_frame(const can::Frame& frame, can::Time end) noexcept override;
  std::optional<Transmission> on_join(can::Time now) noexcept override;
  std::optional<can::Time> next_time() const noexcept override;
  Deed on_time(can::Time now) noexcept override;

 private:
  DeviceSettings settings_;
  std::vector<can::Time> due_;  ///< of each period
};

}  // namespace sim
