#pragma once

#include <string>
#include <variant>
#include <vector>

#include "text/command_line.h"

namespace cansync_sim {

/// What stands on the command line, as text; empty: not given.
struct Arguments {
  std::string interface;
  std::string config;
  std::string slaves;
  std::string sync_id;
  std::string faults;
  std::string device;
  std::string bit_rate;
  std::string lock_time;
  std::string status_parameter;
  std::string memory;
  std::string missing_references;
  std::string seed;
  std::vector<std::string> set;
  std::vector<std::string> references;
  bool master = false;
  bool wait = false;
  bool real = false;
  bool verbose = false;
};

using text::CommandLineEnd;

/// Reads the command line; opens no file and no interface. What the texts say is looked at by `make_setup`.
std::variant<Arguments, CommandLineEnd> parse_arguments(int argc, const char* const* argv);

}  // namespace cansync_sim
