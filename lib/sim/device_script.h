#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "config/problem.h"
#include "sim/scripted_device.h"

/// Scripts of simulated devices: TOML files with tables `[[answer]]` and `[[periodic]]`. docs/cansync-sim.md
/// has every key. Allocates; main thread.
namespace sim {

/// What a device does, and all that is wrong with its script.
struct DeviceScript {
  DeviceSettings device;                ///< of the tables without an error
  std::vector<config::Problem> errors;  ///< in the order of the file; a table with one is left out whole

  /// Nothing of the file can be used.
  bool refused() const noexcept {
    return device.answers.empty() && device.periods.empty() && !errors.empty();
  }
};

/// Reads a script that is in memory; `file` is named in errors.
DeviceScript parse_device_script(std::string_view toml, const std::string& file);

/// Reads the script at `path`, a regular file of up to text::kFileLimit bytes.
DeviceScript load_device_script(const std::string& path);

}  // namespace sim
