#pragma once

#include <functional>
#include <string>
#include <vector>

#include "config/settings.h"

namespace config {

/// What becomes of a running configuration when its file is read again.
struct Changes {
  std::vector<std::string> applied;        ///< keys of options that changed and take effect
  std::vector<std::string> needs_restart;  ///< keys of options that changed and keep their running value
  Settings merged;                         ///< what is given then
};

/// Compares what is given of the running configuration with a newly read one. A change takes effect when its
/// option may change while running and `applies` agrees. What is not given counts as its default; labels are
/// not looked at. Main thread.
Changes compare(const std::vector<Setting>& running, const std::vector<Setting>& wanted,
                const std::function<bool(const Setting&)>& applies);

/// The same when what runs is replaced: `applies` alone says which changes take effect.
Changes replace(const std::vector<Setting>& running, const std::vector<Setting>& wanted,
                const std::function<bool(const Setting&)>& applies);

}  // namespace config
