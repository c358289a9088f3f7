#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "can/frame.h"
#include "daemon/config/daemon_config.h"
#include "layer2/range_filter.h"

/// The whole configuration of a bus of general frames: plain values. `file.h` reads it from a TOML file. Not
/// for the realtime thread.
namespace cansyncd {

/// Sending.
struct SendConfig {
  std::uint16_t queue = 64;                 ///< requests that may wait at the realtime thread, 1..256
  std::chrono::milliseconds timeout{1000};  ///< monitoring time of requests that name none, 1..3'600'000
};

/// A simulated node; looked at only with `BusKind::simulated`.
struct SimNodeConfig {
  unsigned number = 0;                  ///< 0..31
  can::Frame frame;                     ///< a data frame
  std::chrono::milliseconds period{0};  ///< between two of them; 0: sent as the answer to remote frames
};

/// Everything.
struct Layer2Config : DaemonConfig {
  Layer2Config() { bus.bits_per_second = 500'000; }

  std::vector<layer2::ReceiveRange> receive;  ///< by number, at most RangeFilter::kMostRanges, all in order
  SendConfig send;
  std::vector<SimNodeConfig> nodes;  ///< by number, each once
};

}  // namespace cansyncd
