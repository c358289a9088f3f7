#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "plan.h"

namespace cansyncd::campaign {

/// Our daemon is cut off from the bus.
struct Outage {
  enum class Kind : std::uint8_t {
    bus_off,         ///< the controller, which comes back without a reset
    interface_down,  ///< or missing
    cable_off,       ///< nobody acknowledges
  };
  Kind kind = Kind::bus_off;
  can::Time from{};
  can::Time to{};
};

/// What an operator asks for.
struct Order {
  can::Time at{};
  Mode mode = Mode::set_up;
  bool force = false;
};

/// One schedule of the course `other_master`. Times are those of the line, whose clock starts with it.
struct OtherMasterPlan {
  Plan line;  ///< seed, settings, drives, target, lateness, whether frames wake the thread
  AfterOtherMaster after = AfterOtherMaster::resume;
  bool sync_frames = false;                              ///< SYNC is a frame on the bus
  std::vector<std::pair<can::Time, can::Frame>> others;  ///< what the other master hands over, and when
  std::vector<Outage> outages;                           ///< in order, apart
  std::vector<Order> orders;                             ///< in order
  can::Time last{};                                      ///< nothing is provoked after this
};

/// Identifier of the SYNC frames of this course.
inline constexpr std::uint32_t kSyncIdentifier = 0x080;

/// Draws the schedule of a seed.
OtherMasterPlan draw_other_master(std::uint64_t seed);

/// The schedule in words, one line for each thing.
std::string describe(const OtherMasterPlan& plan);

}  // namespace cansyncd::campaign
