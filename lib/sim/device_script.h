#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "config/problem.h"
#include "sim/scripted_device.h"

/// Scripts of simulated devices: TOML files with tables `[[answer]]` and `[[periodic]]`. docs/cansync-sim.md
/// has every key. Allocates; main thread.
namespace sim {

/// What a device does, or all that is wrong with its script.
struct DeviceScript {
  DeviceSettings device;
  std::vector<config::Problem> errors;  ///< in the order of the file
};

/// Reads a script that is in memory; `file` is named in errors.
DeviceScript parse_device_script(std::string_view toml, const std::string& file);

/// Reads the script at `path`, a regular file of up to text::kFileLimit bytes.
DeviceScript load_device_script(const std::string& path);

}  // namespace sim
