#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace cansync::cli {

/// What another program said and how it ended.
struct ChildResult {
  std::string output;  ///< its standard output
  std::string errors;  ///< its standard error, at most 4096 bytes
  int status = 0;      ///< its exit code; 128 and more: ended by a signal
};

/// There is no program of this name.
class NoProgram : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Runs a program to its end, without a shell, with `input` as its standard input. `arguments`: its name,
/// looked up in PATH, and what it is given. Throws NoProgram, and std::system_error when the system refuses.
ChildResult run_child(const std::vector<std::string>& arguments, const std::string& input);

}  // namespace cansync::cli
