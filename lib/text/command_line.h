#pragma once

#include <optional>
#include <string>

namespace CLI {
class App;
}

/// Command lines of programs that say what they say in one way. Main thread (allocates).
namespace text {

/// The program ends after its command line: help or version was asked for, or something in it is wrong.
struct CommandLineEnd {
  bool wrong = false;  ///< `text` is an error
  std::string text;
};

/// Lets `app` read the command line, or a shell complete it (completion.h). Nothing: the program goes on.
std::optional<CommandLineEnd> read_command_line(CLI::App& app, int argc, const char* const* argv);

}  // namespace text
