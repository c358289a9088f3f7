#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "config/problem.h"
#include "sim/fault_protocol.h"
#include "sim/faults.h"

/// Fault scripts: TOML files with one table `[[fault]]` for each fault. docs/fault-scripts.md has every key.
namespace sim {

/// The faults of a script, and all that is wrong with it.
struct FaultScript {
  std::vector<Fault> faults;             ///< those without an error, in the order of the file
  std::vector<config::Position> places;  ///< where the value of each fault's key `kind` stands
  std::vector<config::Problem> errors;   ///< in the order of the file; a table with one is left out whole

  /// Nothing of the file can be used.
  bool refused() const noexcept { return faults.empty() && !errors.empty(); }
};

/// Parses a script that is already in memory; `file` is named in errors, `protocol` has the words for nodes
/// and channels.
FaultScript parse_fault_script(std::string_view toml, const std::string& file, const FaultProtocol& protocol);

/// Reads and parses the script at `path`, a regular file of up to text::kFileLimit bytes.
FaultScript load_fault_script(const std::string& path, const FaultProtocol& protocol);

}  // namespace sim
