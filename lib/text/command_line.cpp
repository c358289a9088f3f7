#include "text/command_line.h"

#include <CLI/CLI.hpp>
#include <sstream>

#include "text/completion.h"

namespace text {

std::optional<CommandLineEnd> read_command_line(CLI::App& app, int argc, const char* const* argv) {
  if (const auto words = words_to_complete(argc, argv); !words.empty())
    return CommandLineEnd{false, completions(app, words)};
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
