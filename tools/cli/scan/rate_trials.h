#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "can/link_facts.h"
#include "cansync/observe/census.h"
#include "cansync/settings/timing.h"
#include "cli/base/child_process.h"

/// Finds the bit rate of a line by listening at each of the four, one after the other.
namespace cansync::cli {

/// One bit rate, and what was heard at it.
struct RateTrial {
  BitRate bit_rate = BitRate::kbit125;
  observe::Census census;
};

/// What the trials are made with. A test stands in for both.
struct RateTools {
  std::function<ChildResult(const std::vector<std::string>& arguments)> ip;  ///< the program `ip`
  std::function<observe::Census()> listen;                                   ///< for a while
  std::function<bool()> stopped;                                             ///< no further rate is tried
  /// Has these commands run when this process ends while what is returned lives; null: not.
  std::function<std::shared_ptr<void>(const std::vector<std::vector<std::string>>& commands)> guard;
};

/// Sets the interface to each bit rate, in listen-only mode, and listens. Afterwards it is as `before` says, with
/// sample point, segments and jump width as `ip` showed them; down when it had no bit rate. Throws std::runtime_error when the driver has no listen-only mode, or `ip`
/// fails; the interface is set back then, too.
std::vector<RateTrial> try_rates(const std::string& interface, const can::LinkFacts& before,
                                 const RateTools& tools);

/// The trial that heard the line: frames without errors, the most of them, and at best an interval that
/// belongs to the bit rate. Null: none. Pure.
const RateTrial* heard_trial(const std::vector<RateTrial>& trials);

}  // namespace cansync::cli
