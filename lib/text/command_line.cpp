#include "text/command_line.h"

#include <CLI/CLI.hpp>
#include <sstream>

namespace text {

std::optional<CommandLineEnd> read_command_line(CLI::App& app, int argc, const char* const* argv) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    std::ostringstream asked;
    std::ostringstream complaint;
    const bool wrong = app.exit(error, asked, complaint) != 0;
    return CommandLineEnd{wrong, wrong ? complaint.str() : asked.str()};
  }
  return std::nullopt;
}

}  // namespace text
