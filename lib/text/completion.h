#pragma once

#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace CLI {
class App;
}

/// What a shell offers at TAB: made of the program's own description of its command line, so that it cannot
/// lag behind. tools/completions/cansync asks for it. Main thread (allocates).
namespace text {

/// A command line that is being typed, up to the word at the cursor.
struct TypedLine {
  std::string verb;  ///< its words with blanks between; empty: none yet, or none there
  std::map<std::string, std::string> options;  ///< values by long name, such as "--bus"
  std::vector<std::string> arguments;          ///< what stands without an option, after the verb
};

/// What an argument may be. `placeholder` is its name in the help, such as SLAVE. An entry that begins with
/// ':' asks the shell: `:files`, `:folders`, `:interfaces` (of the network), `:buses` (files in
/// /etc/cansync).
using CandidateLookup =
    std::function<std::vector<std::string>(std::string_view placeholder, const TypedLine& line)>;

/// The words that may stand in place of the last of `words` (the program's name is not among them; the last
/// may be empty), one a line. Names of verbs and options come from `app`, and so do values of an argument
/// that is written like `0|1|2`; files and folders where the placeholder says so. For everything else
/// `lookup` is asked. In a list with commas the part after the last one is completed. What is not understood
/// gives nothing.
std::string completions(const CLI::App& app, std::span<const std::string_view> words,
                        const CandidateLookup& lookup = {});

/// Do the program's arguments ask for completion (`--complete WORD...`, first of all)? Gives the words.
std::vector<std::string_view> words_to_complete(int argc, const char* const* argv);

}  // namespace text
