#pragma once

#include <string>
#include <variant>
#include <vector>

#include "text/command_line.h"

/// The command line of `cansyncd`. Main thread (allocates).
namespace cansyncd {

/// What stands on the command line; empty: not given.
struct Arguments {
  std::vector<std::string> config;  ///< files to run with, one for each bus
  std::vector<std::string> check;   ///< files to check instead
  std::string last_good;            ///< folder of configurations that have run
  std::string dbc;                  ///< file to print as DBC instead
  std::string trace;
  std::string domain;
  std::vector<std::string> set;  ///< KEY=VALUE
  bool print_default_config = false;
  bool print_options_markdown = false;
  bool print_options_man = false;
};

using text::CommandLineEnd;

/// Reads the command line; opens no file and starts nothing. Texts of options are not looked into.
std::variant<Arguments, CommandLineEnd> parse_arguments(int argc, const char* const* argv);

/// The settings of the command line as "KEY=VALUE", which win over the file.
std::vector<std::string> overrides(const Arguments& arguments);

}  // namespace cansyncd
