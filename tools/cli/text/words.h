#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

/// A line of words as a shell would cut it, and words that were meant. Pure.
namespace cansync::cli {

struct Word {
  std::string text;
  std::size_t column = 1;  ///< of its first character, counted in bytes from 1
};

/// The line cannot be cut; `column` is where the trouble begins.
class WordError : public std::runtime_error {
 public:
  WordError(std::size_t column, const std::string& text) : std::runtime_error(text), column_(column) {}
  std::size_t column() const noexcept { return column_; }

 private:
  std::size_t column_;
};

/// The words of `line`: between blanks and tabulators; '...' takes everything as it is, "..." everything but
/// \" and
/// \\, and outside of both a backslash takes the next character as it is. A # where a word would begin starts
/// a comment. Nothing else of a shell. Throws WordError for a quotation that does not end.
std::vector<Word> split_words(std::string_view line);

/// Letters to be put in, left out, changed or swapped with their neighbour so that one word becomes the
/// other.
std::size_t edit_distance(std::string_view from, std::string_view to);

/// "; did you mean 'status'?" when one of `words` is one or two letters away from what was typed, else
/// nothing.
std::string did_you_mean(std::string_view typed, const std::vector<std::string>& words);

}  // namespace cansync::cli
