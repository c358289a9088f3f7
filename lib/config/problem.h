#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

/// What is wrong with a file that people write. Main thread.
namespace config {

/// Where something stands in a file; lines and columns count from 1, 0 = not known.
struct Position {
  std::string file;
  std::uint32_t line = 0;
  std::uint32_t column = 0;
};

/// Something wrong with a file, in words that name what was found and what is allowed.
struct Problem {
  Position where;
  std::string key;  ///< option, e.g. "bus.name"; empty when no option is concerned
  std::string text;
};

/// "FILE:LINE:COLUMN: KEY: TEXT", with control characters of the file as "\x1b".
std::string to_string(const Problem& problem);

/// Most problems that are told one by one.
inline constexpr std::size_t kProblemsShown = 20;

/// The problems for people, one a line, at most `kProblemsShown` and then how many more there are.
std::string problems_text(const std::vector<Problem>& problems);
/// The same without the end of the last line, as the words of an error.
std::string problems_message(const std::vector<Problem>& problems);

/// Brings problems into the order of the file; those of one place keep theirs.
void sort_by_place(std::vector<Problem>& problems);

}  // namespace config
