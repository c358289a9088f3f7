#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "sim/fault_protocol.h"
#include "sim/faults.h"

/// Fault scripts: TOML files with one table `[[fault]]` for each fault. docs/fault-scripts.md has every key.
namespace sim {

/// One thing that is wrong in a fault script.
struct FaultScriptError {
  std::string file;
  std::size_t line = 0;    ///< from 1; 0: the file as a whole
  std::size_t column = 0;  ///< from 1; 0: the file as a whole
  std::string message;     ///< what was found and what is allowed

  /// `file:line:column: message`.
  std::string text() const;
};

/// A place in a fault script; line and column count from 1.
struct FaultPlace {
  std::size_t line = 0;
  std::size_t column = 0;
};

/// The faults of a script, or all that is wrong with it.
struct FaultScript {
  std::vector<Fault> faults;       ///< in the order of the file; empty when there are errors
  std::vector<FaultPlace> places;  ///< where the value of each fault's key `kind` stands
  std::vector<FaultScriptError> errors;
};

/// Parses a script that is already in memory; `file` is named in errors, `protocol` has the words for nodes
/// and channels.
FaultScript parse_fault_script(std::string_view toml, std::string_view file, const FaultProtocol& protocol);

/// Reads and parses the script at `path`, a regular file of up to text::kFileLimit bytes.
FaultScript load_fault_script(const std::string& path, const FaultProtocol& protocol);

}  // namespace sim
