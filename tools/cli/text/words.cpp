#include "cli/text/words.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace cansync::cli {
namespace {

bool is_blank(char c) noexcept {
  return c == ' ' || c == '\t' || c == '\r';
}

/// Walks over one line.
class Splitter {
 public:
  explicit Splitter(std::string_view line) : line_(line) {}

  std::vector<Word> run() {
    std::vector<Word> words;
    for (;;) {
      while (at_ < line_.size() && is_blank(line_[at_])) ++at_;
      if (at_ == line_.size() || line_[at_] == '#') return words;
      words.push_back({"", at_ + 1});
      take_word(words.back().text);
    }
  }

 private:
  void take_word(std::string& word) {
    while (at_ < line_.size() && !is_blank(line_[at_])) {
      const char c = line_[at_];
      if (c == '\'' || c == '"') {
        take_quotation(word, c);
      } else if (c == '\\') {
        if (at_ + 1 == line_.size())
          throw WordError(at_ + 1, "found \\ at the end of the line; allowed: \\ before a character");
        word += line_[at_ + 1];
        at_ += 2;
      } else {
        word += c;
        ++at_;
      }
    }
  }

  void take_quotation(std::string& word, char mark) {
    const std::size_t start = at_++;
    for (; at_ < line_.size(); ++at_) {
      const char c = line_[at_];
      if (c == mark) {
        ++at_;
        return;
      }
      const bool escapes = mark == '"' && c == '\\' && at_ + 1 < line_.size() &&
                           (line_[at_ + 1] == '"' || line_[at_ + 1] == '\\');
      word += escapes ? line_[++at_] : c;
    }
    throw WordError(start + 1, std::string("found ") + mark + " without a second one on the line");
  }

  std::string_view line_;
  std::size_t at_ = 0;
};

}  // namespace

std::vector<Word> split_words(std::string_view line) {
  return Splitter(line).run();
}

std::size_t edit_distance(std::string_view from, std::string_view to) {
  // Row by row; the one before the last is needed for letters that are swapped.
  std::vector<std::size_t> before(to.size() + 1);
  std::vector<std::size_t> last(to.size() + 1);
  std::vector<std::size_t> row(to.size() + 1);
  std::iota(last.begin(), last.end(), std::size_t{0});
  for (std::size_t i = 1; i <= from.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= to.size(); ++j) {
      const bool same = from[i - 1] == to[j - 1];
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (same ? 0u : 1u)});
      if (i > 1 && j > 1 && from[i - 1] == to[j - 2] && from[i - 2] == to[j - 1])
        row[j] = std::min(row[j], before[j - 2] + 1);
    }
    before.swap(last);
    last.swap(row);
  }
  return last[to.size()];
}

std::string did_you_mean(std::string_view typed, const std::vector<std::string>& words) {
  std::size_t best = 3;
  std::string found;
  for (const std::string& word : words) {
    const std::size_t distance = edit_distance(typed, word);
    // In a short word two other letters make any word of it.
    if (distance >= best || 2 * distance >= std::max(typed.size(), word.size())) continue;
    best = distance;
    found = fmt::format("; did you mean '{}'?", word);
  }
  return found;
}

}  // namespace cansync::cli
