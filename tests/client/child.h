#pragma once

#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <string>

/// How a program ended, and what it printed.
struct Child {
  int exit_code = -1;  ///< -1: by a signal
  std::string output;  ///< stdout and stderr
};

/// Runs a command line to its end.
inline Child run_child(const std::string& command_line) {
  Child result;
  FILE* pipe = popen((command_line + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return result;
  std::array<char, 256> line = {};
  while (fgets(line.data(), line.size(), pipe) != nullptr) result.output += line.data();
  const int status = pclose(pipe);
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return result;
}
